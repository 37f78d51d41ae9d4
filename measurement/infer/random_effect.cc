#include "measurement/infer/random_effect.h"

#include <cmath>

#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {

RandomCoefficients::RandomCoefficients(const Eigen::MatrixXd& gram, Eigen::VectorXd ratios)
    : ratios_(std::move(ratios)) {
  SymmetricEigen eigen = symmetric_eigen(ratios_.asDiagonal() * gram * ratios_.asDiagonal());
  strength_ = std::move(eigen.values);
  directions_ = std::move(eigen.vectors);
}

RandomEffect RandomCoefficients::effect(const Eigen::VectorXd& right) const {
  const Eigen::VectorXd along = directions_.transpose() * ratios_.cwiseProduct(right);
  const auto gain = [&](double variance) {
    double sum = 0;
    for (Eigen::Index i = 0; i < along.size(); ++i) {
      const double wider = 1 + variance * std::max(strength_[i], 0.0);
      sum += variance * along[i] * along[i] / wider - std::log(wider);
    }
    return 0.5 * sum;
  };
  // From an effect far below what any data show to one far above: two steps a decade, then nearer.
  // A wider one would be told by directions that are nothing but rounding (1e-16 of the strongest).
  double best = 0, most = 0, step = std::log(10) / 2;
  const double scale = std::max(1e-300, strength_.maxCoeff());
  const auto look = [&](double log_variance) {
    const double at = gain(std::exp(log_variance));
    if (at > most) most = at, best = log_variance;
  };
  const double first = std::log(1e-3 / scale);
  for (int k = 0; k <= 26; ++k) look(first + k * step);
  if (!(most > 0)) return {.coefficients = Eigen::VectorXd::Zero(right.size())};
  for (; step > 0.02; step *= 0.5) {
    const double centre = best;
    look(centre - 0.5 * step), look(centre + 0.5 * step);
  }
  const double variance = std::exp(best);
  const Eigen::VectorXd drawn =
      variance * along.array() / (1 + variance * strength_.array().max(0.0));
  return {std::sqrt(variance) * ratios_, most, ratios_.cwiseProduct(directions_ * drawn)};
}

Eigen::VectorXd coefficients_of(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right,
                                const Eigen::VectorXd& spread) {
  Eigen::MatrixXd information = gram;
  information.diagonal().array() += spread.array().square().inverse();
  return solve_symmetric(information, right);
}

}  // namespace seam::measurement
