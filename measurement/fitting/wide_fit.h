// A fit for models whose residuals are not smooth in their parameters (latency of held commands,
// play, dead bands, limits): Levenberg-Marquardt whose differences span about one standard
// deviation of each parameter, then a pattern search, and uncertainties from the same wide steps.
// Limits whose neutral value is infinite are fitted as reciprocals.
#pragma once

#include "measurement/problem/problem.h"

namespace seam::measurement {

Fit wide_fit(const Problem& problem, const Model& start, const std::vector<Unknown>& unknowns,
             const Groups& groups);

// Derivatives of the whitened residuals over the same wide steps, by the parameter itself (by its
// reciprocal where it is infinite).
std::vector<std::vector<double>> wide_jacobian(const Problem& problem, const Model& model,
                                               const std::vector<Unknown>& unknowns,
                                               const Groups& groups);

}  // namespace seam::measurement
