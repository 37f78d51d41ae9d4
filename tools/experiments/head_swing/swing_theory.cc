#include "tools/experiments/head_swing/swing_theory.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/maths.h"

namespace seam::tools {

double Swing::pan_rad(double time_s) const {
  return amplitude_rad * maths::sin(2 * maths::kPi * time_s / period_s);
}

double Swing::rate_radps(double time_s) const {
  const double omega = 2 * maths::kPi / period_s;
  return amplitude_rad * omega * maths::cos(omega * time_s);
}

std::vector<double> locked_angles(const Swing& swing, int frames, double phase) {
  std::vector<double> angles;
  for (int k = 0; k < frames; ++k)
    angles.push_back(swing.pan_rad((k + phase) * swing.period_s / frames));
  return angles;
}

int locked_views(const Swing& swing, int frames, double phase, double bearing_rad,
                 double half_view_rad) {
  const std::vector<double> angles = locked_angles(swing, frames, phase);
  return static_cast<int>(std::count_if(angles.begin(), angles.end(), [&](double pan_rad) {
    return std::abs(maths::wrap_angle(bearing_rad - pan_rad)) < half_view_rad;
  }));
}

double stamp_bearing_error_rad(double pan_rate_radps, double row_middle_s) {
  return -pan_rate_radps * row_middle_s;
}

double locked_bias(const ErrorParts& parts, double views, double swings) {
  return std::sqrt(parts.common * parts.common + parts.view * parts.view / views +
                   parts.frame * parts.frame / (views * swings));
}

}  // namespace seam::tools
