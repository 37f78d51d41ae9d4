#include "measurement/kinds/photometry/structure/photometry_spread_tests.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>

#include "measurement/kinds/photometry/likelihood/photometry_likelihood.h"
#include "measurement/kinds/photometry/structure/photometry_mean_tests.h"
#include "measurement/numerics/legendre.h"

namespace seam::measurement {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Functions that the variance is compared with, and their sums over all samples.
struct SpreadTarget {
  std::string covariate;
  int count;
  PlaceBasis basis;
  VectorXd statistic = VectorXd::Zero(count);
  MatrixXd covariance = MatrixXd::Zero(count, count);
};

std::vector<SpreadTarget> spread_targets(int levels) {
  std::vector<SpreadTarget> targets;
  if (levels > 1) {
    targets.push_back({"illumination", levels, [](const SamplePlace& p, double, VectorXd& b) {
                         b[static_cast<Eigen::Index>(p.level)] = 1;
                       }});
  }
  const auto polynomial = [](double x, int count, VectorXd& b) {
    for (int k = 0; k < count; ++k) b[k] = legendre(k + 1, x);
  };
  targets.push_back(
      {"row", 4, [=](const SamplePlace& p, double, VectorXd& b) { polynomial(p.y, 4, b); }});
  targets.push_back(
      {"column", 4, [=](const SamplePlace& p, double, VectorXd& b) { polynomial(p.x, 4, b); }});
  targets.push_back({"radius", 4, [=](const SamplePlace& p, double, VectorXd& b) {
                       polynomial(2 * p.radius - 1, 4, b);
                     }});
  return targets;
}

// How far each sample's variance is from its prediction, relative to that.
std::vector<double> relative_excess(const PhotometryData& data, const LevelSums& sum,
                                    const LevelPrediction& level, const CertainValues& certain) {
  const double freedom = (static_cast<double>(sum.frames.size()) - 1) * (1 - 1.0 / data.width_px);
  std::vector<double> z(level.mean.size());
  for (size_t i = 0; i < z.size(); ++i) {
    // Clipped values have too little variance left to test.
    const bool tells =
        level.variance[i] >= 0.05 && !certain.is_certain(level.mean[i], level.variance[i]);
    z[i] = tells ? sum.scatter[i] / (freedom * level.variance[i]) - 1 : 0;
  }
  return z;
}

// Measured, so that tails other than the Gaussian's do not matter.
double variance_of(const std::vector<double>& z) {
  double square = 0, mean = 0;
  for (const double own : z) mean += own, square += own * own;
  mean /= static_cast<double>(z.size());
  return std::max(square / static_cast<double>(z.size()) - mean * mean, 1e-12);
}

// Adds the samples of level `l`.
void add_level(const PhotometryData& data, size_t l, const LevelPrediction& level,
               const std::vector<double>& z, std::vector<SpreadTarget>& targets) {
  const double variance = variance_of(z);
  for (SpreadTarget& target : targets) {
    VectorXd b = VectorXd::Zero(target.count);
    size_t i = 0;
    for (int v = 0; v < data.height_px; ++v) {
      for (int u = 0; u < data.width_px; ++u) {
        for (int c = 0; c < data.channels; ++c, ++i) {
          b.setZero();
          target.basis(place_of(data, l, u, v, c), level.gain_slope[i], b);
          target.statistic += z[i] / variance * b;
          target.covariance.selfadjointView<Eigen::Lower>().rankUpdate(b, 1 / variance);
        }
      }
    }
  }
}

StructureTest judge_spread(const SpreadTarget& target, double mean_variance) {
  const MatrixXd full = target.covariance.selfadjointView<Eigen::Lower>();
  const auto [chi2, freedom] = chi2_of(target.statistic, full, full.diagonal());
  StructureTest test{.chi2 = chi2, .freedom = freedom};
  const double relative =
      std::sqrt(std::max(0.0, chi2 - freedom) / std::max(full.diagonal().maxCoeff(), 1e-300));
  test.structure = {.residual = "dn",
                    .moment = "spread",
                    .covariate = target.covariate,
                    .strength = std::sqrt(mean_variance) * std::sqrt(relative)};
  return test;
}

}  // namespace

std::vector<StructureTest> spread_tests(const PhotometryView& view,
                                        const PhotometryPrediction& prediction) {
  std::vector<SpreadTarget> targets = spread_targets(static_cast<int>(view.sums.levels.size()));
  const CertainValues certain(view.data, prediction.chain);
  double mean_variance = 0, count = 0;
  for (size_t l = 0; l < view.sums.levels.size(); ++l) {
    const LevelSums& sum = view.sums.levels[l];
    if (sum.frames.size() < 2) continue;
    const LevelPrediction& level = prediction.levels[l];
    for (const double variance : level.variance) mean_variance += variance, count += 1;
    add_level(view.data, l, level, relative_excess(view.data, sum, level, certain), targets);
  }
  std::vector<StructureTest> tests;
  if (count == 0) return tests;
  mean_variance /= count;
  for (const SpreadTarget& target : targets) tests.push_back(judge_spread(target, mean_variance));
  return tests;
}

}  // namespace seam::measurement
