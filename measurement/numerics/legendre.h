// Legendre polynomials, as tests of structure use them.
#pragma once

#include <algorithm>
#include <cmath>

namespace seam::measurement {

// Of a covariate scaled to [-1, 1], in which alone std::legendre is defined: rounding, or a grey
// value beyond the range, counts as the end.
inline double legendre(int degree, double x) {
  return std::legendre(static_cast<unsigned>(degree), std::clamp(x, -1.0, 1.0));
}

}  // namespace seam::measurement
