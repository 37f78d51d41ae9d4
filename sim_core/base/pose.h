// Rigid poses in monogram notation: X_AB maps coordinates in frame B to frame A, and
// X_AC = X_AB * X_BC (adjacent letters must match). Frames: W world (+x towards the sky-blue goal,
// y left, z up), B body (x forward, y left, z up), C camera (x right, y down, z forward).
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace seam {

using Vec3 = glm::dvec3;
using Mat3 = glm::dmat3;  // Column-major: m[column][row].

struct Pose {
  Mat3 R{1.0};  // R_AB: columns are B's axes in A.
  Vec3 p{0.0};  // p_AB: B's origin in A, metres.

  Pose operator*(const Pose& X_BC) const { return {R * X_BC.R, R * X_BC.p + p}; }
  Vec3 operator*(const Vec3& p_B) const { return R * p_B + p; }
  Pose inverse() const {
    const Mat3 R_BA = glm::transpose(R);
    return {R_BA, -(R_BA * p)};
  }
};

// Rotation by angle about a unit axis (Rodrigues).
Mat3 rotation_about(const Vec3& axis, double angle_rad);
// Rz(z) * Ry(y) * Rx(x).
Mat3 rotation_zyx(double x_rad, double y_rad, double z_rad);
// Unit quaternion (w, x, y, z) to rotation; the quaternion is normalised first.
Mat3 rotation_from_quaternion(double w, double x, double y, double z);

Pose translation(const Vec3& p_AB);
Pose rotation(const Mat3& R_AB);

// From the last link of a head (x forward, y left, z up) to the camera (x right, y down,
// z forward): the camera looks along the link's +x, image right is -y, image down is -z.
Mat3 link_to_camera_axes();

}  // namespace seam
