// Candidates before they are fitted: where one linear step of each ends, the best first.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "measurement/search/candidates.h"

namespace seam::tools {

using Prospects = std::vector<std::optional<measurement::Prospect>>;

// What one step of Gauss and Newton reaches with an effect.
struct StepEnd {
  double gain_ll = 0;  // Of all groups.
  double error = 0;    // Of held-out groups.
};

// Nothing where there is no such step, and where it ends no better than it began: it may lead too
// far where predictions bend.
std::optional<StepEnd> end_of_step(const measurement::Problem& problem,
                                   const measurement::Grown& base,
                                   const measurement::Prospect& prospect);

// The same as the linearisation alone expects it, where predictions are dear.
std::optional<StepEnd> expected_end(const measurement::Problem& problem,
                                    const measurement::Grown& base,
                                    const measurement::Prospect& prospect);

// Some rows that show about where fits to all of them lead; none where that saves little.
std::optional<measurement::FewRows> rows_for_first_sight(const measurement::Problem& problem,
                                                         const measurement::Model& model);

// Where a prospect without such a step leads at first sight (another lens, a spread, flat fields):
// fitted to these rows, or, where none stand for all, the best of a few values beside the model as
// it is. Nothing where it gains nothing.
struct FirstSight {
  measurement::Model model;
  StepEnd end;
};
std::optional<FirstSight> first_sight(const measurement::Problem& problem,
                                      const measurement::Grown& base,
                                      const measurement::Prospect& prospect,
                                      const std::optional<measurement::FewRows>& few);

// The order in which prospects are fitted: those whose step gains most, then those of which a step
// says nothing, then noises.
std::vector<size_t> most_promising_first(const Prospects& prospects,
                                         const std::vector<std::optional<StepEnd>>& ends);

// A candidate as the page lists it, from where its step, or first sight, ends: in this model; one
// of so many prospects.
nlohmann::json prospect_json(const measurement::Problem& problem, const measurement::Grown& base,
                             const measurement::Prospect& prospect, const measurement::Model& there,
                             const StepEnd& end, size_t prospects);

}  // namespace seam::tools
