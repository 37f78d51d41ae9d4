#include "measurement/infer/random_effect.h"

#include <cmath>

#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

// In the directions of the Gram matrix's eigenvectors the coefficients are independent.
struct Directions {
  Eigen::VectorXd strength, along;  // Eigenvalues, and the right side by eigenvector.

  double gain(double variance) const {
    double sum = 0;
    for (Eigen::Index i = 0; i < strength.size(); ++i) {
      const double wider = 1 + variance * std::max(strength[i], 0.0);
      sum += variance * along[i] * along[i] / wider - std::log(wider);
    }
    return 0.5 * sum;
  }
};

}  // namespace

RandomEffect random_effect(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right,
                           const Eigen::VectorXd& ratios) {
  const SymmetricEigen eigen = symmetric_eigen(ratios.asDiagonal() * gram * ratios.asDiagonal());
  const Directions directions{eigen.values, eigen.vectors.transpose() * ratios.cwiseProduct(right)};
  // From an effect far below what any data show to one far above: two steps a decade, then nearer.
  // A wider one would be told by directions that are nothing but rounding (1e-16 of the strongest).
  double best = 0, most = 0, step = std::log(10) / 2;
  const double scale = std::max(1e-300, eigen.values.maxCoeff());
  const auto look = [&](double log_variance) {
    const double gain = directions.gain(std::exp(log_variance));
    if (gain > most) most = gain, best = log_variance;
  };
  const double first = std::log(1e-3 / scale);
  for (int k = 0; k <= 26; ++k) look(first + k * step);
  if (!(most > 0)) return {.coefficients = Eigen::VectorXd::Zero(right.size())};
  for (; step > 0.02; step *= 0.5) {
    const double centre = best;
    look(centre - 0.5 * step), look(centre + 0.5 * step);
  }
  Eigen::VectorXd spread = std::exp(0.5 * best) * ratios;
  Eigen::VectorXd coefficients = coefficients_of(gram, right, spread);
  return {std::move(spread), most, std::move(coefficients)};
}

Eigen::VectorXd coefficients_of(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right,
                                const Eigen::VectorXd& spread) {
  Eigen::MatrixXd information = gram;
  information.diagonal().array() += spread.array().square().inverse();
  return solve_symmetric(information, right);
}

}  // namespace seam::measurement
