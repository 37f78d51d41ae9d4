#include "measurement/noise/rounded_angle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace seam::measurement {
namespace {

double above(double z) {
  return 0.5 * std::erfc(z / std::numbers::sqrt2);
}

}  // namespace

RoundedAngle::RoundedAngle(double step_rad, double noise_rad)
    : step_rad_(step_rad), noise_rad_(noise_rad) {
  most_ = log_chance(0);
  sigma_rad_ = step_rad * std::exp(-most_) / std::sqrt(2 * std::numbers::pi);
  // By the middle rule over half a step, in which an angle shows one of the steps around it.
  constexpr int kPlaces = 32, kSteps = 8;
  for (int place = 0; place < kPlaces; ++place) {
    const double angle_rad = 0.5 * step_rad * (place + 0.5) / kPlaces;
    for (int k = -kSteps; k <= kSteps; ++k) {
      const double miss = k * step_rad - angle_rad, cost = z(miss);
      mean_square_ += std::exp(log_chance(miss)) * cost * cost / kPlaces;
    }
  }
}

double RoundedAngle::log_chance(double miss_rad) const {
  const double near = (std::abs(miss_rad) - 0.5 * step_rad_) / noise_rad_;
  constexpr double kFar = 25;  // Beyond it the chance is the tail's first term.
  if (near > kFar) return -0.5 * near * near - std::log(near * std::sqrt(2 * std::numbers::pi));
  return std::log(above(near) - above(near + step_rad_ / noise_rad_));
}

double RoundedAngle::z(double miss_rad) const {
  return std::copysign(std::sqrt(2 * std::max(0.0, most_ - log_chance(miss_rad))), miss_rad);
}

double RoundedAngle::slope(double miss_rad) const {
  const double by_rad = 0.01 * noise_rad_;
  return (z(miss_rad + by_rad) - z(miss_rad - by_rad)) / (2 * by_rad);
}

}  // namespace seam::measurement
