// Turns as vectors: along the axis, as long as the angle, by the right hand.
#pragma once

#include <glm/geometric.hpp>

#include "sim_core/base/maths.h"
#include "sim_core/base/pose.h"

namespace seam {

inline Mat3 rotation_by(const Vec3& turn_rad) {
  const double angle = glm::length(turn_rad);
  return angle > 0 ? rotation_about(turn_rad / angle, angle) : Mat3(1.0);
}

// Of turns by less than pi.
inline Vec3 turn_of(const Mat3& R) {
  const Vec3 sine = 0.5 * Vec3(R[1][2] - R[2][1], R[2][0] - R[0][2], R[0][1] - R[1][0]);
  const double length = glm::length(sine);
  if (length == 0) return sine;
  return maths::atan2(length, 0.5 * (R[0][0] + R[1][1] + R[2][2] - 1)) / length * sine;
}

}  // namespace seam
