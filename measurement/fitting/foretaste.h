// What a fit to a few groups tells of the one to all: held against all rows, it is behind the best
// fit by no more than chance can put it there. So what is far behind stays there, and what leads
// is fitted to all.
#pragma once

#include <optional>
#include <vector>

#include "measurement/fitting/assess.h"
#include "measurement/fitting/few_groups.h"

namespace seam::measurement {

// The few rows whose fits tell of all at this threshold of what is material; none where sets are
// small, groups share draws, or where few short groups are held out in turn.
std::optional<FewRows> foretasters(const Problem& problem, const Model& model, double material);

// A fit to these rows, held against all.
struct Foretaste {
  Assessment assessment;
  double most_ll = 0;  // What a fit to all rows may reach.
};

Foretaste foretaste(const Problem& problem, const FewRows& few, const Model& model,
                    const std::vector<Unknown>& unknowns);

// Whether a fit to all groups would stay below this log-likelihood, as a few groups tell; false
// where none do.
bool stays_below(const Problem& problem, const Model& model, const std::vector<Unknown>& unknowns,
                 double log_likelihood);

}  // namespace seam::measurement
