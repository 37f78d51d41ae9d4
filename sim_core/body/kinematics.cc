#include "sim_core/body/kinematics.h"

#include "sim_core/base/maths.h"
#include "sim_core/base/sines.h"

namespace seam {
namespace {

using maths::SineCosine;
using maths::sines_and_cosines;

// Rotations about a coordinate axis, without the general formula's work.
Mat3 about_x(const SineCosine& angle) {
  const auto [s, c] = angle;
  return Mat3(1, 0, 0, 0, c, s, 0, -s, c);
}
Mat3 about_y(const SineCosine& angle) {
  const auto [s, c] = angle;
  return Mat3(c, 0, -s, 0, 1, 0, s, 0, c);
}
Mat3 about_z(const SineCosine& angle) {
  const auto [s, c] = angle;
  return Mat3(c, s, 0, -s, c, 0, 0, 0, 1);
}

}  // namespace

Pose neck_pose(const RobotBody& body, double tilt_rad) {
  return {about_y({maths::sin(-tilt_rad), maths::cos(-tilt_rad)}), body.tilt_axis_m};
}

Pose head_pose(const RobotBody& body, double tilt_rad, double pan_rad, double roll_rad) {
  const auto [tilt, pan, roll] = sines_and_cosines(-tilt_rad, pan_rad, roll_rad);
  const Mat3 R_BP = about_y(tilt) * about_z(pan);
  return {R_BP * about_x(roll), body.tilt_axis_m + R_BP * Vec3(0, 0, body.roll_height_m)};
}

Pose camera_link_pose(const RobotBody& body, const JointAngles& joints) {
  if (body.tree.present()) return body.tree.camera_link_pose(joints);
  Pose X = head_pose(body, joints[kTilt], joints[kPan], joints[kRoll]);
  X.p += X.R[0] * body.camera_forward_m;
  return X;
}

LegPose leg_pose(const RobotBody& body, int leg, const JointAngles& joints) {
  const double rotator = joints[static_cast<size_t>(leg_joint(leg, 0))];
  const double elevator = joints[static_cast<size_t>(leg_joint(leg, 1))];
  const double knee = joints[static_cast<size_t>(leg_joint(leg, 2))];
  const double sx = leg_side_x(leg), sy = leg_side_y(leg);
  const auto [at_rotator, at_elevator, at_knee] =
      sines_and_cosines(-sx * rotator, sy * elevator, -sx * knee);
  LegPose pose;
  pose.X_BU = {about_y(at_rotator) * about_x(at_elevator),
               {sx * body.shoulder_x_m, sy * body.shoulder_y_m, 0}};
  const Vec3 knee_U{sx * body.upper_leg_offset_m, 0, -body.upper_leg_m};
  pose.X_BL = pose.X_BU * Pose{about_y(at_knee), knee_U};
  pose.p_BPaw = pose.X_BL * Vec3(0, 0, -(leg < 2 ? body.lower_front_m : body.lower_hind_m));
  return pose;
}

std::vector<Pose> link_poses(const RobotBody& body, const JointAngles& joints) {
  if (body.tree.present()) return body.tree.link_poses(joints);
  std::vector<Pose> X_BLinks(kLinks);
  X_BLinks[0] = Pose{};
  X_BLinks[1] = neck_pose(body, joints[kTilt]);
  X_BLinks[2] = head_pose(body, joints[kTilt], joints[kPan], joints[kRoll]);
  for (int leg = 0; leg < kLegs; ++leg) {
    const LegPose pose = leg_pose(body, leg, joints);
    X_BLinks[static_cast<size_t>(3 + 2 * leg)] = pose.X_BU;
    X_BLinks[static_cast<size_t>(4 + 2 * leg)] = pose.X_BL;
  }
  return X_BLinks;
}

}  // namespace seam
