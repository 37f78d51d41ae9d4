// The trot: diagonal pairs of legs swing in turn; the body rides on the paws that are down.
#include <algorithm>
#include <cmath>

#include "sim_core/base/maths.h"
#include "sim_core/world/robot.h"

namespace seam {
namespace {

// Rounds the change from one diagonal to the other, m.
constexpr double kSettling = 5e-4;

}  // namespace

// Four paws are never in one plane but for a twist: one diagonal is as far above their common plane
// as the other is below it. The body has the tilt of the plane and stands on the lower diagonal.
Attitude attitude_on_paws(const RobotBody& body, const std::array<Vec3, kLegs>& paws_B) {
  Vec3 mean{0.0};
  for (const Vec3& paw : paws_B) mean += 0.25 * paw;
  // Least squares for the plane z = a x + b y + c.
  double xx = 0, yy = 0, xy = 0, xz = 0, yz = 0;
  for (const Vec3& paw : paws_B) {
    const Vec3 d = paw - mean;
    xx += d.x * d.x, yy += d.y * d.y, xy += d.x * d.y, xz += d.x * d.z, yz += d.y * d.z;
  }
  const double determinant = xx * yy - xy * xy;
  // Paws in a line carry no plane: the body stays level.
  const bool plane = determinant > 1e-3 * xx * yy;
  const double a = plane ? (xz * yy - yz * xy) / determinant : 0;
  const double b = plane ? (yz * xx - xz * xy) / determinant : 0;
  double twist2 = 0;
  for (const Vec3& paw : paws_B) {
    const Vec3 d = paw - mean;
    const double above = d.z - a * d.x - b * d.y;
    twist2 += 0.25 * above * above;
  }
  const double lower = std::sqrt(twist2 + kSettling * kSettling) - kSettling;
  const double c = mean.z - a * mean.x - b * mean.y - lower;
  const double norm = std::sqrt(1 + a * a + b * b);
  // World's up in the body's frame is n = (-a, -b, 1) / norm = the third row of Ry(pitch) Rx(roll).
  return {.height_m = -c / norm + body.paw_radius_m,
          .pitch_rad = maths::asin(a / norm),
          .roll_rad = maths::atan2(-b, 1.0)};
}

void gait_angles(const RobotBody& body, double phase, const BodyVelocity& stride,
                 JointAngles& joints) {
  const Gait& gait = body.gait;
  const double reach = body.upper_leg_m + body.lower_front_m;
  const double speed =
      std::max({std::abs(stride.vx_mps) / std::max(gait.max_vx_mps, 1e-6),
                std::abs(stride.vy_mps) / std::max(gait.max_vy_mps, 1e-6),
                std::abs(stride.omega_radps) / std::max(gait.max_omega_radps, 1e-6)});
  const double lift = gait.lift_knee_rad * std::min(1.0, 2 * speed);
  for (int leg = 0; leg < kLegs; ++leg) {
    const double sx = leg_side_x(leg), sy = leg_side_y(leg);
    const bool first_pair = leg == 0 || leg == 3;
    const double angle = 2 * maths::kPi * (phase + (first_pair ? 0.0 : 0.5));
    const double sweep = maths::cos(angle);
    const double up = std::max(0.0, maths::sin(angle));  // In the air during the first half.
    // The paw's travel over ground, half a stride each way, as an angle at the shoulder.
    const double forward =
        0.25 * gait.step_s * (stride.vx_mps - sy * body.shoulder_y_m * stride.omega_radps) / reach;
    const double sideways =
        0.25 * gait.step_s * (stride.vy_mps + sx * body.shoulder_x_m * stride.omega_radps) / reach;
    // In the air the leg moves forwards, from -1 to +1 of the sweep.
    joints[static_cast<size_t>(leg_joint(leg, 0))] = gait.stance_rotator_rad - sx * forward * sweep;
    joints[static_cast<size_t>(leg_joint(leg, 1))] =
        gait.stance_elevator_rad - sy * sideways * sweep;
    joints[static_cast<size_t>(leg_joint(leg, 2))] = gait.stance_knee_rad + lift * up * up;
  }
}

}  // namespace seam
