#include "measurement/kinds/points/points_predictor.h"

#include <cmath>

namespace seam::measurement {

std::vector<Vec3> places_of_rows(const PointsData& data, const effects::TargetShape& shape,
                                 const std::vector<Vec3>& displaced_m) {
  if (shape.is_plan() && displaced_m.empty()) return data.p_W;
  std::vector<Vec3> shift_W;
  for (size_t point = 0; point < data.target.names.size(); ++point) {
    shift_W.push_back(data.target.placed_W(point, shape) - data.target.plan_W[point]);
    if (!displaced_m.empty()) shift_W.back() += data.target.axes_W * displaced_m[point];
  }
  std::vector<Vec3> places_W = data.p_W;
  for (size_t row = 0; row < places_W.size(); ++row)
    places_W[row] += shift_W[static_cast<size_t>(data.point_of_row[row])];
  return places_W;
}

effects::ImagePoint PointsPredictor::image_at(size_t row, const Vec3& p_W, double late_s,
                                              const double* joint_errors) const {
  const int camera = data_.camera_of_row[row];
  const auto& [timing, motion, projection] = eyes_[static_cast<size_t>(camera)];
  double v = data_.v_px[row];
  if (timing.line_delay_s == 0) {
    const double t = instant(row, v) + late_s;
    return projection.project(motion.to_camera(t, p_W, joint_errors), t, v, effects::kGreen,
                              data_.columns_of(row));
  }
  effects::ImagePoint point;
  constexpr double kSettled_px = 1e-3;
  double previous_v = v, previous_f = 0, f = 0;
  for (int step = 0; step < 30; ++step) {
    const double t = instant(row, v) + late_s;
    point = projection.project(motion.to_camera(t, p_W, joint_errors), t, v, effects::kGreen,
                               data_.columns_of(row));
    if (!point.visible) return point;
    // The row at which the point is seen is the fixed point of v -> image row; secant steps.
    f = point.light_v - v;
    if (std::abs(f) < 1e-8) break;
    const double slope = step == 0 || v == previous_v ? -1 : (f - previous_f) / (v - previous_v);
    previous_v = v, previous_f = f;
    v = std::abs(slope) > 0.1 ? v - f / slope : point.light_v;
  }
  // No row sees a point that runs away from each: one far beside the image of a fast camera.
  if (!(std::abs(f) < kSettled_px)) point.visible = false;
  return point;
}

std::vector<int> lines_behind_camera(const Model& model, const MeasurementSet& set) {
  Facts facts;
  const PointsData data = read_points(set, false, facts);
  std::vector<int> lines;
  if (data.rig.type() == Rig::Type::unknown) return lines;
  std::vector<Rig::Motion> motions;
  for (const CameraView& view : data.cameras)
    motions.push_back(data.rig.motion(model_of(model, view.name)));
  for (size_t row = 0; row < data.p_W.size(); ++row) {
    const Rig::Motion& motion = motions[static_cast<size_t>(data.camera_of_row[row])];
    if (motion.to_camera(data.stamp_s[row], data.p_W[row]).z <= 0)
      lines.push_back(facts.line_of_row[row]);
  }
  return lines;
}

}  // namespace seam::measurement
