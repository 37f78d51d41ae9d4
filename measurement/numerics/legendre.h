// Legendre polynomials over the range of a quantity, as tests of structure and smooth functions use
// them.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace seam::measurement {

// Of a covariate scaled to [-1, 1], in which alone std::legendre is defined: rounding, or a grey
// value beyond the range, counts as the end.
inline double legendre(int degree, double x) {
  return std::legendre(static_cast<unsigned>(degree), std::clamp(x, -1.0, 1.0));
}

// Scales values to [-1, 1] over their range; false where one is not finite or all are the same.
inline bool scale_to_range(std::vector<double>& values) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double value : values) {
    if (!std::isfinite(value)) return false;
    low = std::min(low, value), high = std::max(high, value);
  }
  if (!(high - low > 1e-12 * std::max(std::abs(low), std::abs(high)))) return false;
  const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
  for (double& value : values) value = (value - middle) / half;
  return true;
}

}  // namespace seam::measurement
