// Medians and robust sigmas.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace seam::measurement {

// The middle value (the upper of two); 0 for no values.
template <class Number = double>
Number median_of(std::vector<Number> values) {
  if (values.empty()) return 0;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

// Standard deviation of a normal distribution with the same median absolute value about zero.
inline double robust_sigma(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return median_of(std::move(values)) / 0.6744897501960817;
}

// Standard deviation of normal values among which are some far ones: that of the values within
// three robust sigmas, more than twice as efficient as the median.
inline double clipped_sigma(const std::vector<double>& values) {
  constexpr double kClip = 3, kVarianceWithin = 0.9733369246625415;  // Of a unit normal.
  const double limit = kClip * robust_sigma(values);
  double sum2 = 0, count = 0;
  for (const double value : values) {
    if (std::abs(value) <= limit) sum2 += value * value, ++count;
  }
  return count > 0 ? std::sqrt(sum2 / (count * kVarianceWithin)) : 0;
}

}  // namespace seam::measurement
