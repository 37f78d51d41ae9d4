// Which parameters of a model the data tell, when all of them are fitted together.
#pragma once

#include <optional>
#include <vector>

#include "measurement/search/candidates.h"

namespace seam::measurement {

// The unknowns that can be fitted together: those of effects of the mean whose column of the
// Jacobian is not spanned by the columns before it. Parameters that comparisons refit anyway come
// first, so that of two that do the same (a lens's focal length and an error of it) the one that
// was fitted before stays free. The others are named in `untold`, with what absorbs them.
std::vector<Unknown> told_apart(const Problem& problem, const Model& model,
                                const std::vector<Unknown>& unknowns,
                                std::vector<NotTestable>& untold);

// One step of Gauss and Newton in all unknowns.
struct LinearStep {
  std::optional<Model> to;  // Where it ends, inside the bounds.
  double expected_ll = std::numeric_limits<double>::infinity();  // Where the problem is smooth.
};

// Which of the effect's parameters these groups can say anything of, beyond what the `others` that
// are refitted anyway absorb; and, where the problem is smooth, what one step would reach on them.
// `near` is an evaluation to begin from.
std::vector<size_t> testable_parameters(const Problem& problem, const Model& model,
                                        const std::vector<Unknown>& others,
                                        const EffectDefinition& effect, const Groups& groups,
                                        const Evaluation* near, std::vector<NotTestable>& reasons,
                                        LinearStep& step);

// Of effects of which several values do the same together (a factor that both polynomials of a
// quotient have in common) those with the widest bounds (the highest powers) and the last are at
// neutral, and none of those that go later is left out in their place: of equals the simplest,
// whose errors can be told.
Grown less_tangled(const Problem& problem, Grown grown);

}  // namespace seam::measurement
