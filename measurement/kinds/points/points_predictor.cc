#include "measurement/kinds/points/points_predictor.h"

#include <cmath>

namespace seam::measurement {

effects::ImagePoint PointsPredictor::image(size_t row, double late_s,
                                           const double* joint_errors) const {
  const Vec3& p_W = data_.p_W[row];
  double v = data_.v_px[row];
  if (timing_.line_delay_s == 0) {
    const double t = instant(data_.stamp_s[row], v) + late_s;
    return projection_.project(motion_.to_camera(t, p_W, joint_errors), t, v);
  }
  effects::ImagePoint point;
  double previous_v = v, previous_f = 0;
  for (int step = 0; step < 30; ++step) {
    const double t = instant(data_.stamp_s[row], v) + late_s;
    point = projection_.project(motion_.to_camera(t, p_W, joint_errors), t, v);
    if (!point.visible) return point;
    // The row at which the point is seen is the fixed point of v -> image row; secant steps.
    const double f = point.v - v;
    if (std::abs(f) < 1e-8) break;
    const double slope = step == 0 || v == previous_v ? -1 : (f - previous_f) / (v - previous_v);
    previous_v = v, previous_f = f;
    v = std::abs(slope) > 0.1 ? v - f / slope : point.v;
  }
  return point;
}

}  // namespace seam::measurement
