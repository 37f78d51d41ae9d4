// The evidence of a random effect: of coefficients that are normal, independent and of one size,
// which is the likeliest one. Named draws and smooth fields without a name are all of this form, so
// that their evidence is on one scale with the log-likelihoods of fits (docs/design/engine.md).
#pragma once

#include <Eigen/Core>

namespace seam::measurement {

struct RandomEffect {
  double size = 0;          // Standard deviation of a coefficient that makes the data likeliest.
  double log_evidence = 0;  // Gained over no effect; 0: none.
  Eigen::VectorXd coefficients;  // Their mean, given the data.
};

// Residuals r of unit noise are columns * coefficients + noise: `gram` is columns' columns, `right`
// columns' r. The gain is
//   ln p(r | size) - ln p(r | 0) = 1/2 right' (gram + 1/size^2)^-1 right - 1/2 ln |1 + size^2
//   gram|.
RandomEffect random_effect(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right);

// The mean of coefficients of this size.
Eigen::VectorXd coefficients_of(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right,
                                double size);

}  // namespace seam::measurement
