// The joints of an ERS-210, by index; of other robots as many as their trees have.
#pragma once

#include <array>
#include <string_view>

namespace seam {

enum Joint : int {
  kTilt,
  kPan,
  kRoll,
  kLeftFrontRotator,
  kLeftFrontElevator,
  kLeftFrontKnee,
  kRightFrontRotator,
  kRightFrontElevator,
  kRightFrontKnee,
  kLeftHindRotator,
  kLeftHindElevator,
  kLeftHindKnee,
  kRightHindRotator,
  kRightHindElevator,
  kRightHindKnee,
};
inline constexpr int kHeadJoints = 3;
inline constexpr int kLegs = 4;  // Left front, right front, left hind, right hind.
inline constexpr int kJointsALeg = 3;
inline constexpr int kJoints = kHeadJoints + kLegs * kJointsALeg;

inline constexpr std::array<std::string_view, kJoints> kJointNames = {
    "tilt",
    "pan",
    "roll",
    "left_front_rotator",
    "left_front_elevator",
    "left_front_knee",
    "right_front_rotator",
    "right_front_elevator",
    "right_front_knee",
    "left_hind_rotator",
    "left_hind_elevator",
    "left_hind_knee",
    "right_hind_rotator",
    "right_hind_elevator",
    "right_hind_knee",
};

constexpr int leg_joint(int leg, int joint) {
  return kHeadJoints + leg * kJointsALeg + joint;
}

// Of a robot of any build: humanoids with hands have some 60.
inline constexpr int kMostJoints = 64;
using JointAngles = std::array<double, kMostJoints>;

}  // namespace seam
