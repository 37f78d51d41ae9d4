#include "sim_core/base/pose.h"

#include <cmath>
#include <tuple>

#include "sim_core/base/maths.h"
#include "sim_core/base/sines.h"

namespace seam {

namespace {

Mat3 rotation_about(const Vec3& axis, const maths::SineCosine& angle) {
  const auto [s, c] = angle;
  const double d = 1 - c;
  const auto& [x, y, z] = std::tie(axis.x, axis.y, axis.z);
  return Mat3(c + x * x * d, y * x * d + z * s, z * x * d - y * s,  //
              x * y * d - z * s, c + y * y * d, z * y * d + x * s,  //
              x * z * d + y * s, y * z * d - x * s, c + z * z * d);
}

}  // namespace

Mat3 rotation_about(const Vec3& axis, double angle_rad) {
  return rotation_about(axis, {maths::sin(angle_rad), maths::cos(angle_rad)});
}

Mat3 rotation_zyx(double x_rad, double y_rad, double z_rad) {
  const auto [x, y, z] = maths::sines_and_cosines(x_rad, y_rad, z_rad);
  return rotation_about({0, 0, 1}, z) * rotation_about({0, 1, 0}, y) * rotation_about({1, 0, 0}, x);
}

Mat3 rotation_from_quaternion(double w, double x, double y, double z) {
  const double scale = 1 / std::sqrt(w * w + x * x + y * y + z * z);
  w *= scale, x *= scale, y *= scale, z *= scale;
  return Mat3(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),  //
              2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),  //
              2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y));
}

Pose translation(const Vec3& p_AB) {
  return {Mat3(1.0), p_AB};
}
Pose rotation(const Mat3& R_AB) {
  return {R_AB, Vec3(0.0)};
}

Mat3 link_to_camera_axes() {
  // Columns are the camera's x (right = -y), y (down = -z) and z (forward = +x) in the link.
  return Mat3(0, -1, 0, 0, 0, -1, 1, 0, 0);
}

}  // namespace seam
