#include "measurement/judge/evidence.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "measurement/judge/decisions.h"

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd eigenvalues_of(const MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}

// In the parameter's unit there.
double typical_size(const effects::Parameter& parameter, double value) {
  return std::isfinite(parameter.neutral) ? parameter.scale : value * value / parameter.scale;
}

}  // namespace

double distance_in_sizes(const effects::Parameter& parameter, double value) {
  if (parameter.required) return 0;
  return std::isfinite(parameter.neutral) ? (value - parameter.neutral) / parameter.scale
                                          : parameter.scale / value;
}

double prior_size(const effects::Parameter& parameter, double value, double sigma) {
  const double typical = typical_size(parameter, value);
  if (parameter.required) return typical;
  const double away = std::abs(distance_in_sizes(parameter, value)) * typical;
  return std::min(typical, std::max(away, kReachOfNothing * sigma));
}

double occam_factor(const MatrixXd& information, const VectorXd& sizes) {
  if (sizes.size() == 0) return 0;
  double factor = 0;
  for (const double known : eigenvalues_of(sizes.asDiagonal() * information * sizes.asDiagonal()))
    factor -= 0.5 * std::log1p(std::max(known, 0.0));
  return factor;
}

double occam_factor(const Assessment& assessment) {
  const Fit& fit = assessment.fit;
  const size_t count = fit.sigma.size();
  if (count == 0 || fit.covariance.size() != count * count) return 0;
  const Eigen::Map<const MatrixXd> stated(fit.covariance.data(), static_cast<Index>(count),
                                          static_cast<Index>(count));
  double factor = 0;
  std::vector<Index> known;  // Of which the data say something.
  std::vector<double> sizes;
  for (size_t k = 0; k < count; ++k) {
    const Unknown& unknown = assessment.unknowns[k];
    const effects::Parameter& parameter =
        assessment.model.find(unknown.effect)->definition->parameters[unknown.parameter];
    const double away = distance_in_sizes(parameter, fit.value[k]);
    factor -= std::log1p(away * away);
    const double size = prior_size(parameter, fit.value[k], fit.sigma[k]);
    const auto at = static_cast<Index>(k);
    if (!std::isfinite(size) || !std::isfinite(fit.sigma[k]) || !(stated(at, at) > 0)) continue;
    known.push_back(at), sizes.push_back(size);
  }
  if (known.empty()) return factor;
  const VectorXd by_size =
      Eigen::Map<const VectorXd>(sizes.data(), std::ssize(sizes)).cwiseInverse();
  const MatrixXd covariance =
      by_size.asDiagonal() * MatrixXd(stated(known, known)) * by_size.asDiagonal();
  if (!covariance.allFinite()) return factor;
  constexpr double kLeast = 1e-14;  // Differences of predictions tell no less.
  for (const double variance : eigenvalues_of(covariance))
    factor -= 0.5 * std::log1p(1 / std::max(variance, kLeast));
  return factor;
}

}  // namespace seam::measurement
