// Moments of a Gaussian value after clipping, quantisation and rounding to the file.
#include <algorithm>
#include <cmath>

#include "effects/stages/sensor/sensor.h"
#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

double normal_cdf(double z) {
  return 0.5 * std::erfc(-z * 0.70710678118654752440);
}

// Sums over the values that the file can hold; each holds the probability of its interval. Exact.
Moments sum_over_values(const SensorChain& chain, Moments value, double step, double top) {
  const double sigma = std::sqrt(value.variance_dn2);
  const double full = std::min(chain.full_dn, 1e9);
  const double low = std::clamp(std::min(value.mean_dn - 9 * sigma, full), -step, top + step);
  const double high = std::clamp(std::min(value.mean_dn + 9 * sigma, full), -step, top + step);
  const double first = std::floor(low / step - 1);
  const double last = std::ceil(high / step + 1);
  // P(clipped < edge): all of the probability above full_dn stands at full_dn itself.
  const auto below = [&](double edge) {
    if (edge > full) return 1.0;
    return normal_cdf((edge - value.mean_dn) / sigma);
  };
  double cumulative = 0, mean = 0, square = 0;
  const double origin = std::clamp(std::floor(value.mean_dn + 0.5), 0.0, top);
  for (double k = first; k <= last; ++k) {
    const double upper = k == last ? 1.0 : below((k + 0.5) * step);
    const double weight = upper - cumulative;
    cumulative = upper;
    const double dn = std::clamp(std::floor(k * step + 0.5), 0.0, top) - origin;
    mean += weight * dn;
    square += weight * dn * dn;
  }
  return {origin + mean, std::max(0.0, square - mean * mean)};
}

}  // namespace

Moments file_moments(const SensorChain& chain, Moments value, int file_bits) {
  const double step = quantisation_step(chain, file_bits);
  const double top = full_scale_dn(file_bits);
  const double sigma = std::sqrt(value.variance_dn2);
  if (sigma < 1e-6 * step) {
    return {static_cast<double>(to_file(chain, value.mean_dn, file_bits)), 0};
  }
  const double margin = 7 * sigma + step;
  const bool clipped =
      value.mean_dn - margin < 0 || value.mean_dn + margin > std::min(top, chain.full_dn);
  // Far from the ends Sheppard's corrections are exact to 1e-8 DN once sigma is a step.
  if (!clipped && sigma > step) {
    return {value.mean_dn, value.variance_dn2 + step * step / 12};
  }
  if (sigma < 16 * step) return sum_over_values(chain, value, step, top);
  // Many steps a sigma: rounding is 1/12, clipping is that of a censored Gaussian between the
  // values that the file has: a field beyond the highest is that value, not half a step more.
  const double low = 0, high = std::min(top, chain.full_dn);
  const double a = (low - value.mean_dn) / sigma, b = (high - value.mean_dn) / sigma;
  // All beyond an end: differences of what is far larger would leave no digit.
  constexpr double kBeyond = 40;
  if (a > kBeyond) return {low, 0};
  if (b < -kBeyond) return {high, 0};
  const double phi_a = maths::exp(-0.5 * a * a) * 0.3989422804014327;
  const double phi_b = maths::exp(-0.5 * b * b) * 0.3989422804014327;
  const double below = normal_cdf(a), inside = normal_cdf(b) - below, above = 1 - normal_cdf(b);
  const double z0 = std::max(a, -kBeyond), z1 = std::min(b, kBeyond);
  const double m1 = below * z0 + (phi_a - phi_b) + above * z1;
  const double m2 = below * z0 * z0 + inside + (z0 * phi_a - z1 * phi_b) + above * z1 * z1;
  return {value.mean_dn + sigma * m1,
          std::max(0.0, value.variance_dn2 * (m2 - m1 * m1)) + inside * step * step / 12};
}

}  // namespace seam::effects
