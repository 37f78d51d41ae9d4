// Forward kinematics of a robot: from joint angles to the poses of its links in the body's frame.
// An ERS-210's axes: tilt about [0, -1, 0] (positive up), pan about [0, 0, 1] (positive left), roll
// about [1, 0, 0]. Legs: rotators and knees turn about the body's y axis, positive away from the
// body's middle; elevators lift the leg outwards.
#pragma once

#include <vector>

#include "sim_core/body/robot_body.h"

namespace seam {

// The neck's frame after tilt, at the tilt axis (the pan axis passes through it).
Pose neck_pose(const RobotBody& body, double tilt_rad);
// The head at the roll centre, after tilt, pan and roll.
Pose head_pose(const RobotBody& body, double tilt_rad, double pan_rad, double roll_rad);
// X_BL: the link at the camera (x along the optical axis, y left, z up), before mount effects; of
// an ERS-210 the last link of the head.
Pose camera_link_pose(const RobotBody& body, const JointAngles& joints);

struct LegPose {
  Pose X_BU;    // Upper leg, at the shoulder, along -z.
  Pose X_BL;    // Lower leg, at the knee, along -z.
  Vec3 p_BPaw;  // The paw's centre.
};
LegPose leg_pose(const RobotBody& body, int leg, const JointAngles& joints);

// X_BLink for every link: as Link counts, or as the tree does.
std::vector<Pose> link_poses(const RobotBody& body, const JointAngles& joints);

// +1 for front legs, -1 for hind legs; +1 for left legs, -1 for right legs.
constexpr double leg_side_x(int leg) {
  return leg < 2 ? 1 : -1;
}
constexpr double leg_side_y(int leg) {
  return leg % 2 == 0 ? 1 : -1;
}

}  // namespace seam
