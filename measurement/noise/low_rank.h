// Whitening of residuals that share causes: S = D + U U', D diagonal.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "measurement/problem/problem.h"

namespace seam::measurement {

// Multiplies the whitened residuals of these scalars (already divided by their own sigmas) so that
// the common causes count: column k of `causes` is the native effect of cause k at one sigma.
// Adds what is missing to the group's log det and to the scalars' sigmas.
void whiten_low_rank(const std::vector<size_t>& scalars, const Eigen::MatrixXd& causes, int group,
                     Evaluation& evaluation);

}  // namespace seam::measurement
