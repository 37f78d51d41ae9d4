// Medians and robust sigmas.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace seam::measurement {

// The middle value (the upper of two); 0 for no values.
inline double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

// Standard deviation of a normal distribution with the same median absolute value about zero.
inline double robust_sigma(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return median_of(std::move(values)) / 0.6744897501960817;
}

}  // namespace seam::measurement
