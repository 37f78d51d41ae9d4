// The evidence of a random effect: of coefficients that are normal and independent, with spreads of
// which the ratios are given and the common factor is the likeliest one. Named draws and smooth
// fields without a name are all of this form, so that their evidence is on one scale with the
// log-likelihoods of fits (docs/design/engine.md).
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

namespace seam::measurement {

struct RandomEffect {
  Eigen::VectorXd spread;   // Standard deviations of coefficients that make the data likeliest.
  double log_evidence = 0;  // Gained over no effect; 0: none.
  Eigen::VectorXd coefficients;  // Their mean, given the data.
};

// Residuals r of unit noise are columns * coefficients + noise: `gram` is columns' columns, `right`
// columns' r, and with S = diag(spread), s its factor over `ratios`, the gain is
//   ln p(r | s) - ln p(r | 0) = 1/2 right' (gram + S^-2)^-1 right - 1/2 ln |1 + S gram S|.
// Dear to make, and cheap to ask again of other residuals.
class RandomCoefficients {
 public:
  RandomCoefficients(const Eigen::MatrixXd& gram, Eigen::VectorXd ratios);
  RandomEffect effect(const Eigen::VectorXd& right) const;

 private:
  // At this variance; `drawn`: the coefficients, as `along` turned and over their ratios.
  double gain(double variance, const Eigen::VectorXd& along, Eigen::VectorXd* drawn) const;

  Eigen::VectorXd ratios_;
  Eigen::Tridiagonalization<Eigen::MatrixXd> scaled_;  // Of gram, scaled by the ratios.
};

// The mean of coefficients with these spreads, none of which is 0.
Eigen::VectorXd coefficients_of(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right,
                                const Eigen::VectorXd& spread);

}  // namespace seam::measurement
