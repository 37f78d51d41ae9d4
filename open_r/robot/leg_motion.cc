#include "open_r/robot/leg_motion.h"

#include <algorithm>
#include <cmath>

namespace seam::open_r {
namespace {

constexpr double kShoulderX = 0.065, kShoulderY = 0.0625, kUpper = 0.0695, kUpperOffset = 0.009,
                 kLowerFront = 0.0654, kLowerHind = 0.0676;
// A paw this near to the lowest one stands, m.
constexpr double kStands = 0.004;
// A gait lifts diagonal pairs; of three paws or more that stand, all carry.
constexpr int kPaws = 4;

}  // namespace

std::array<PawPlace, 4> paw_places(const LegAngles& legs_rad) {
  std::array<PawPlace, 4> places;
  for (size_t leg = 0; leg < kPaws; ++leg) {
    const double sx = leg < 2 ? 1 : -1, sy = leg % 2 == 0 ? 1 : -1;
    const double rotator = -sx * legs_rad[3 * leg], elevator = sy * legs_rad[3 * leg + 1],
                 knee = -sx * legs_rad[3 * leg + 2];
    const double lower = leg < 2 ? kLowerFront : kLowerHind;
    // In the upper leg's frame: along -z, bent at the knee about y.
    const double x_U = sx * kUpperOffset - lower * std::sin(knee),
                 z_U = -kUpper - lower * std::cos(knee);
    // Turned about x by the elevator, then about y by the rotator.
    const double y_E = -z_U * std::sin(elevator), z_E = z_U * std::cos(elevator);
    places[leg] = {sx * kShoulderX + x_U * std::cos(rotator) + z_E * std::sin(rotator),
                   sy * kShoulderY + y_E, -x_U * std::sin(rotator) + z_E * std::cos(rotator)};
  }
  return places;
}

BodyMotion motion_of_legs(const LegAngles& before_rad, const LegAngles& after_rad,
                          double duration_s) {
  const std::array<PawPlace, 4> before = paw_places(before_rad), after = paw_places(after_rad);
  double lowest = 0;
  for (const PawPlace& paw : after) lowest = std::min(lowest, paw.z);

  // Mean velocity of the paws that stand, and about which point they turn.
  double n = 0, x = 0, y = 0, vx = 0, vy = 0;
  const auto stands = [&](size_t leg) { return after[leg].z < lowest + kStands; };
  for (size_t leg = 0; leg < kPaws; ++leg) {
    if (!stands(leg)) continue;
    n += 1;
    x += after[leg].x, y += after[leg].y;
    vx += (after[leg].x - before[leg].x) / duration_s;
    vy += (after[leg].y - before[leg].y) / duration_s;
  }
  x /= n, y /= n, vx /= n, vy /= n;
  double turn = 0, inertia = 0;
  for (size_t leg = 0; leg < kPaws; ++leg) {
    if (!stands(leg)) continue;
    const double rx = after[leg].x - x, ry = after[leg].y - y;
    const double ux = (after[leg].x - before[leg].x) / duration_s - vx,
                 uy = (after[leg].y - before[leg].y) / duration_s - vy;
    turn += rx * uy - ry * ux;
    inertia += rx * rx + ry * ry;
  }
  // The ground stands still: the body moves against its paws, and about its own origin.
  const double omega = inertia > 1e-6 ? -turn / inertia : 0;
  return {-vx + omega * y, -vy - omega * x, omega};
}

}  // namespace seam::open_r
