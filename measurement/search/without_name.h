// Causes without a name: smooth functions and formulas of what residuals may depend on compete with
// the steps of a search, on one scale of log-evidence.
#pragma once

#include <optional>
#include <vector>

#include "measurement/search/search.h"

namespace seam::measurement {

// The best smooth functions beside one of these models, each of which grew from the one before.
std::optional<UnnamedCause> unnamed_beside(const Problem& problem, const std::vector<Grown>& grown,
                                           double material, const KnownCauses& known);

// Whether such functions leave no more than noise: nothing for a motor, which has a memory.
bool explained_without_name(const Problem& problem, const std::vector<Grown>& grown,
                            double material, const KnownCauses& known);

// Whether they leave no more than noise, and explain the set better beside one of the models on a
// search's way than beside the last: the steps since then imitate them, and so would further ones.
bool names_imitate(const Problem& problem, const std::vector<Grown>& way, double material,
                   const KnownCauses& known);

// Where smooth functions explain the set better beside some of the steps, the others imitate them:
// they are steps no more. Neither are those that smooth functions can take the place of.
void look_for_unnamed(const Problem& problem, const KnownCauses& known, SearchResult& result);

// What speaks against a step leaves it no explanation: where smooth functions take most of what
// the doubted steps take, and leave nothing but noise, they are steps no more. Returns whether they
// went.
bool leave_out_doubted(const Problem& problem, const KnownCauses& known, SearchResult& result);

// The same for a formula: it is looked for where smooth functions were found or explain as much as
// several steps, where these leave more than noise, and instead of spreads. Returns whether steps
// went.
bool look_for_formula(const Problem& problem, const Progress& progress, const KnownCauses& known,
                      SearchResult& result);

}  // namespace seam::measurement
