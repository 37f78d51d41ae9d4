// What a set says of parameters where its kind has a likelihood and no residual vectors: second
// differences of the log-likelihood at the truth that the set was made with.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "measurement/fitting/parameter_space.h"
#include "measurement/plan/detection.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {

// The coordinate along which a likelihood is quadratic, from a parameter's own z: variances add up,
// standard deviations do not. And d z by it.
double to_quadratic(const Coordinate& coordinate, double z);
double quadratic_slope(const Coordinate& coordinate, double z);

// The look at these unknowns around `truth`, of which the first `base` are refitted anyway. By
// unknown, `way` is how far the effect is from neutral. All are in those coordinates.
EffectLook look_by_likelihood(const Problem& made, const Model& truth,
                              const std::vector<Unknown>& unknowns, const Eigen::VectorXd& way,
                              size_t base);

}  // namespace seam::measurement
