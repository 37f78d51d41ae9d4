#include "measurement/judge/rate.h"

#include <algorithm>
#include <cmath>

namespace seam::measurement {
namespace {

double wilson(int hits, int trials, double side) {
  if (trials == 0) return side > 0 ? 1 : 0;
  constexpr double z = 1.959964;
  const double n = trials, p = hits / n, z2n = z * z / n;
  const double middle = p + 0.5 * z2n, reach = z * std::sqrt(p * (1 - p) / n + 0.25 * z2n / n);
  return std::clamp((middle + side * reach) / (1 + z2n), 0.0, 1.0);
}

}  // namespace

double Rate::low() const {
  return wilson(hits, trials, -1);
}
double Rate::high() const {
  return wilson(hits, trials, 1);
}

}  // namespace seam::measurement
