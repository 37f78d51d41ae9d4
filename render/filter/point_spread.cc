#include "render/filter/point_spread.h"

#include <cmath>

#include "sim_core/base/maths.h"

namespace seam::render {

std::vector<float> point_spread(const effects::Optics& optics) {
  const double sigma = optics.blur_sigma_px;
  if (sigma <= 0) return {};
  const double variance = sigma * sigma;
  std::vector<double> weights;
  if (sigma < kLeastSampledSigma_px && optics.blur_window_px == 0) {
    // 2 w1 + 8 w2 = variance, 2 w1 + 32 w2 = 3 variance^2.
    const double w2 = (3 * variance * variance - variance) / 24;
    const double w1 = variance / 2 - 4 * w2;
    weights = {w2, w1, 1 - 2 * (w1 + w2), w1, w2};
  } else {
    const int radius = optics.blur_window_px > 0 ? optics.blur_window_px / 2
                                                 : static_cast<int>(std::ceil(4 * sigma));
    double sum = 0;
    for (int k = -radius; k <= radius; ++k)
      sum += weights.emplace_back(maths::exp(-k * k / (2 * variance)));
    for (double& weight : weights) weight /= sum;
  }
  return {weights.begin(), weights.end()};
}

}  // namespace seam::render
