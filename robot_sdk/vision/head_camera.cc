#include "robot_sdk/vision/head_camera.h"

#include <algorithm>
#include <cmath>

namespace seam::sdk {
namespace {

// About +z: positive turns left. About -y: positive turns up. About +x: roll.
Vector3 pan(Vector3 p, float angle) {
  const float c = std::cos(angle), s = std::sin(angle);
  return {c * p.x - s * p.y, s * p.x + c * p.y, p.z};
}
Vector3 tilt(Vector3 p, float angle) {
  const float c = std::cos(angle), s = std::sin(angle);
  return {c * p.x - s * p.z, p.y, s * p.x + c * p.z};
}
Vector3 roll(Vector3 p, float angle) {
  const float c = std::cos(angle), s = std::sin(angle);
  return {p.x, c * p.y - s * p.z, s * p.y + c * p.z};
}

}  // namespace

int colour_factor(int frame_width_px, int colours_width_px) {
  return std::max(1, frame_width_px / colours_width_px);
}

CameraBelief CameraBelief::of_colours(int frame_width_px, int frame_height_px, int width_px,
                                      int height_px) const {
  const int factor = colour_factor(frame_width_px, width_px);
  const float k = static_cast<float>(factor);
  // Pixel centres are at whole numbers.
  const auto shrunk = [&](float centre_px, int full_px, int small_px) {
    return (centre_px - 0.5f * static_cast<float>(full_px - factor * small_px) - 0.5f * (k - 1)) /
           k;
  };
  CameraBelief camera = *this;
  camera.cx_px = shrunk(cx_px, frame_width_px, width_px);
  camera.cy_px = shrunk(cy_px, frame_height_px, height_px);
  camera.fx_px /= k, camera.fy_px /= k;
  return camera;
}

float BodyRay::bearing_rad() const {
  return std::atan2(direction.y, direction.x);
}

float BodyRay::elevation_rad() const {
  return std::atan2(direction.z, std::sqrt(direction.x * direction.x + direction.y * direction.y));
}

std::optional<Vector3> BodyRay::at_height(float height_above_ground_m, float body_height_m) const {
  const float drop = height_above_ground_m - body_height_m - origin_m.z;
  if (direction.z == 0) return std::nullopt;
  const float distance = drop / direction.z;
  if (!(distance > 0)) return std::nullopt;
  return Vector3{origin_m.x + distance * direction.x, origin_m.y + distance * direction.y,
                 origin_m.z + distance * direction.z};
}

BodyRay ray_of(float u_px, float v_px, const HeadAngles& head, const CameraBelief& camera,
               const NeckBelief& neck) {
  // Undistort: the inverse of r_d = 2 r / (1 + sqrt(1 - 4 kappa r^2)) is r = r_d / (1 + kappa
  // r_d^2).
  const float xd = (u_px - camera.cx_px) / camera.fx_px;
  const float yd = (v_px - camera.cy_px) / camera.fy_px;
  const float scale = 1 / (1 + camera.kappa * (xd * xd + yd * yd));
  // Camera to link: image right is -y, image down is -z, forward is +x.
  const float length = std::sqrt(1 + scale * scale * (xd * xd + yd * yd));
  const Vector3 in_link{1 / length, -xd * scale / length, -yd * scale / length};
  const auto to_neck = [&](Vector3 p) {
    return tilt(pan(roll(p, head.roll_rad), head.pan_rad), head.tilt_rad);
  };
  const Vector3 ahead = to_neck({neck.camera_forward_m, 0, 0});
  const Vector3 up = tilt({0, 0, neck.neck_m}, head.tilt_rad);
  return {{neck.tilt_axis_forward_m + up.x + ahead.x, up.y + ahead.y,
           neck.tilt_axis_up_m + up.z + ahead.z},
          to_neck(in_link)};
}

}  // namespace seam::sdk
