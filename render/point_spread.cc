#include "render/point_spread.h"

#include <cmath>

#include "sim_core/maths.h"

namespace seam::render {
namespace {

constexpr double kLeastSampledSigma = 0.7;

}  // namespace

int point_spread_radius(double sigma_px) {
  if (sigma_px <= 0) return 0;
  return sigma_px < kLeastSampledSigma ? 2 : static_cast<int>(std::ceil(4 * sigma_px));
}

std::vector<float> point_spread(double sigma_px) {
  const int radius = point_spread_radius(sigma_px);
  if (radius == 0) return {};
  std::vector<double> weights(2 * radius + 1);
  const double variance = sigma_px * sigma_px;
  if (sigma_px < kLeastSampledSigma) {
    // 2 w1 + 8 w2 = variance, 2 w1 + 32 w2 = 3 variance^2.
    const double w2 = (3 * variance * variance - variance) / 24;
    const double w1 = variance / 2 - 4 * w2;
    weights = {w2, w1, 1 - 2 * (w1 + w2), w1, w2};
  } else {
    double sum = 0;
    for (int k = -radius; k <= radius; ++k) sum += weights[k + radius] = maths::exp(-k * k / (2 * variance));
    for (double& weight : weights) weight /= sum;
  }
  return {weights.begin(), weights.end()};
}

}  // namespace seam::render
