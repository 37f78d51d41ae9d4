// How the body moves over ground when a program commands its legs: as the paws that stand do not
// slip. Kinematics of an ERS-210, as models/robot_ers210.yaml has them.
#pragma once

#include <array>
#include <optional>

namespace seam::open_r {

struct BodyMotion {
  double vx_m_s = 0, vy_m_s = 0, omega_rad_s = 0;
};

// Left front, right front, left hind, right hind; each rotator, elevator, knee.
using LegAngles = std::array<double, 12>;

struct PawPlace {
  double x = 0, y = 0, z = 0;
};
// The paws' centres in the body's frame.
std::array<PawPlace, 4> paw_places(const LegAngles& legs_rad);

// The body's mean velocity while the legs go from one posture to the next.
BodyMotion motion_of_legs(const LegAngles& before_rad, const LegAngles& after_rad,
                          double duration_s);

}  // namespace seam::open_r
