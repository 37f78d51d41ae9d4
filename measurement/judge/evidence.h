// One scale for explanations: log-evidence. What a parameter's record says of its size is a prior,
// and an explanation pays for what it might have said and did not (the Occam factor of MacKay
// 1992). So the simpler of two that fit alike is ahead, a parameter that stays at its neutral value
// costs more than it gains, and two that stand for each other pay once.
#pragma once

#include <Eigen/Core>

#include "measurement/fitting/assess.h"

namespace seam::measurement {

// A parameter's distance from neutral in sizes that its record calls typical; 0 of one that must be
// given. Where the neutral value is infinite, both are those of the reciprocal.
double distance_in_sizes(const effects::Parameter& parameter, double value);

// The width of its prior: the typical size, or, as small effects are no rarer than typical ones,
// the distance itself; but no less than what a value that is not there may reach with this error.
double prior_size(const effects::Parameter& parameter, double value, double sigma);

// What the parameters that were fitted add to the log-likelihood, with the information F that data
// have of them, the sizes S of their priors, and their distances t from neutral in typical sizes:
//   -1/2 ln det(1 + S F S) - sum ln(1 + t^2),
// the second for priors with the tails of Cauchy, which allow of any size.
double occam_factor(const Assessment& assessment);

// The first part alone.
double occam_factor(const Eigen::MatrixXd& information, const Eigen::VectorXd& sizes);

}  // namespace seam::measurement
