#include "measurement/kinds/points/motion/path_sight.h"

#include <cmath>

#include "effects/stages/timing.h"

namespace seam::measurement {

using Eigen::Vector2d;

RowCamera::RowCamera(const effects::Model& model, const std::vector<CameraView>& views,
                     const GyroscopeBeside* beside)
    : cameras(model, views),
      turns(beside == nullptr ? nullptr : std::make_shared<const ReadTurns>(*beside, model)) {
  double first_s = 0;
  for (const CameraView& view : views) {
    const effects::Timing timing = effects::timing_of(model_of(model, view.name));
    const double late_s = timing.row_middle_after_stamp_s(0, 0);
    if (clocks.empty()) first_s = late_s;
    clocks.push_back({timing.line_delay_s, late_s - first_s});
  }
}

PathPoint point_on_path(const RowCamera& camera, const Stretch& stretch,
                        const std::vector<Control>& controls, double t_s, bool with_slopes) {
  return camera.turns ? turning_path_at(*camera.turns, stretch, controls, t_s, with_slopes)
                      : path_at(stretch, controls, t_s, with_slopes);
}

namespace {

// The row at which a point is seen is the fixed point of row -> row of its image at that instant.
effects::ImagePoint seen_at(const RowCamera& camera, const Stretch& stretch,
                            const std::vector<Control>& controls, const PathSighting& point,
                            double& instant_s) {
  constexpr int kSteps = 30;
  constexpr double kExact_px = 1e-6;
  const RowClock& clock = camera.clocks[static_cast<size_t>(point.camera)];
  effects::ImagePoint image;
  double v = point.v_px, previous_v = v, previous_f = 0;
  for (int step = 0; step < kSteps; ++step) {
    instant_s = point.stamp_s + clock.late_s + clock.line_delay_s * v;
    const PathPoint path =
        point_on_path(camera, stretch, controls, instant_s, /*with_slopes=*/false);
    image = camera.cameras.project(path.R * point.p_T + path.middle_C, point.stamp_s, v,
                                   point.camera, point.columns);
    const double f = image.light_v - v;
    if (!image.visible || clock.line_delay_s == 0 || std::abs(f) < kExact_px) break;
    const double slope = step == 0 || v == previous_v ? -1 : (f - previous_f) / (v - previous_v);
    previous_v = v, previous_f = f;
    v = std::abs(slope) > 0.1 ? v - f / slope : image.light_v;
  }
  return image;
}

}  // namespace

bool image_on_path(const PathLayout& layout, const RowCamera& camera,
                   const std::vector<Control>& controls, const PathSighting& point, Vector2d& uv) {
  double instant_s = 0;
  const effects::ImagePoint image =
      seen_at(camera, layout.of_frame(point.frame), controls, point, instant_s);
  uv = {image.u, image.v};
  return image.visible;
}

bool look_on_path(const PathLayout& layout, const RowCamera& camera,
                  const std::vector<Control>& controls, const PathSighting& point, PathLook& look) {
  const Stretch& stretch = layout.of_frame(point.frame);
  double instant_s = 0;
  const effects::ImagePoint here = seen_at(camera, stretch, controls, point, instant_s);
  if (!here.visible) return false;
  const PathPoint path = point_on_path(camera, stretch, controls, instant_s, /*with_slopes=*/true);
  const Vec3 arm = path.R * point.p_T, p_C = arm + path.middle_C;
  Eigen::Matrix<double, 2, 3> by_C;
  const double h = 1e-6 * glm::length(p_C);
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 moved_C = p_C;
    moved_C[axis] += h;
    const effects::ImagePoint there =
        camera.cameras.project(moved_C, point.stamp_s, here.v, point.camera, point.columns);
    if (!there.visible) return false;
    by_C.col(axis) << (there.u - here.u) / h, (there.v - here.v) / h;
  }
  // A point that moves to another row is seen at another instant.
  const Vec3 rate = glm::cross(path.turning, arm) + path.moving;
  const Vector2d rate_px = by_C * Eigen::Vector3d(rate.x, rate.y, rate.z);
  const double line_delay_s = camera.clocks[static_cast<size_t>(point.camera)].line_delay_s;
  const double share = 1 / (1 - line_delay_s * rate_px[1]);
  Eigen::Matrix2d follow;
  follow << 1, line_delay_s * rate_px[0] * share, 0, share;
  Eigen::Matrix3d cross;  // d p_C = turn x arm + shift.
  cross << 0, arm.z, -arm.y, -arm.z, 0, arm.x, arm.y, -arm.x, 0;
  const Vector2d weight(1 / point.sigma_u, 1 / point.sigma_v);
  const Eigen::Matrix<double, 2, 3> slopes = -(weight.asDiagonal() * (follow * by_C));
  look.weights = path.weights;
  look.by_controls.setZero();
  for (int j = 0; j < path.weights.count; ++j) {
    look.by_controls.middleCols<3>(kControlUnknowns * j) = slopes * cross * path.turn_by_control[j];
    look.by_controls.middleCols<3>(kControlUnknowns * j + 3) =
        path.weights.weight[j] * slopes * path.shift_by_shift;
  }
  for (int axis = 0; axis < 3; ++axis)
    look.by_place.col(axis) =
        slopes * Eigen::Vector3d(path.R[axis][0], path.R[axis][1], path.R[axis][2]);
  look.uv = Vector2d(here.u, here.v);
  look.z = weight.cwiseProduct(Vector2d(point.u_px - here.u, point.v_px - here.v));
  return true;
}

}  // namespace seam::measurement
