#include "measurement/infer/random_effect.h"

#include <cmath>
#include <limits>

#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {

RandomCoefficients::RandomCoefficients(const Eigen::MatrixXd& gram, Eigen::VectorXd ratios)
    : ratios_(std::move(ratios)),
      scaled_(Eigen::MatrixXd(ratios_.asDiagonal() * gram * ratios_.asDiagonal())) {}

double RandomCoefficients::gain(double variance, const Eigen::VectorXd& along,
                                Eigen::VectorXd* drawn) const {
  const auto& diagonal = scaled_.diagonal();
  const auto& beside = scaled_.subDiagonal();
  const Eigen::Index count = along.size();
  // 1 + variance * gram as L D L', with `rest` of L rest = along.
  Eigen::VectorXd pivot(count), rest(count), below = Eigen::VectorXd::Zero(count);
  double gained = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    pivot[i] = 1 + variance * diagonal[i], rest[i] = along[i];
    if (i > 0) {
      below[i] = variance * beside[i - 1] / pivot[i - 1];
      pivot[i] -= below[i] * variance * beside[i - 1];
      rest[i] -= below[i] * rest[i - 1];
    }
    if (!(pivot[i] > 0)) return -std::numeric_limits<double>::infinity();  // Rounding alone.
    gained += variance * rest[i] * rest[i] / pivot[i] - std::log(pivot[i]);
  }
  if (drawn != nullptr) {
    *drawn = variance * rest.cwiseQuotient(pivot);
    for (Eigen::Index i = count - 1; i > 0; --i) (*drawn)[i - 1] -= below[i] * (*drawn)[i];
  }
  return 0.5 * gained;
}

RandomEffect RandomCoefficients::effect(const Eigen::VectorXd& right) const {
  const Eigen::VectorXd along =
      scaled_.matrixQ().transpose() * Eigen::VectorXd(ratios_.cwiseProduct(right));
  // From an effect far below what any data show to one far above: two steps a decade, then nearer.
  // A wider one would be told by directions that are nothing but rounding (1e-16 of the strongest).
  double best = 0, most = 0, step = std::log(10) / 2;
  const double scale = std::max(1e-300, scaled_.diagonal().maxCoeff());
  const auto look = [&](double log_variance) {
    const double at = gain(std::exp(log_variance), along, nullptr);
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
  Eigen::VectorXd drawn;
  gain(variance, along, &drawn);
  const Eigen::VectorXd coefficients = scaled_.matrixQ() * drawn;
  return {std::sqrt(variance) * ratios_, most, ratios_.cwiseProduct(coefficients)};
}

Eigen::VectorXd coefficients_of(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right,
                                const Eigen::VectorXd& spread) {
  Eigen::MatrixXd information = gram;
  information.diagonal().array() += spread.array().square().inverse();
  return solve_symmetric(information, right);
}

}  // namespace seam::measurement
