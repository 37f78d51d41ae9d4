// What a behaviour may command its robot.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim_core/base/time.h"
#include "sim_core/body/joints.h"
#include "sim_core/body/locomotion.h"

namespace seam {

struct JointTarget {
  int joint = kTilt;       // Index (joints.h).
  double angle_rad = 0;    // Targets beyond the joint's range are clamped to it.
  double speed_radps = 0;  // No faster than this; 0: the joint's top speed.
};

// OPEN-R takes joint targets in frames of 8 ms; a decision may bring several.
struct JointFrame {
  SimDuration offset;  // After the instant at which the command takes effect; >= 0, ascending.
  std::vector<JointTarget> targets;
};

// `grab` holds a ball that lies between the front legs until a kick or `release`.
enum class Kick : uint8_t {
  none,
  leg_forward,
  leg_left,
  leg_right,
  head_left,
  head_right,
  grab,
  release
};
inline constexpr int kKicks = 8;
std::string to_string(Kick kick);

// Absent parts leave as is what an earlier command said.
struct RobotCommand {
  std::vector<JointFrame> joints;
  std::optional<BodyVelocity> walk;  // Beyond the gait's top speed: scaled down to it.
  Kick kick = Kick::none;
};

// The limits that no command may exceed, whatever the robot.
struct CommandLimits {
  static constexpr int kMaxJointFrames = 64;
  static constexpr int kMaxTargetsAFrame = kMostJoints;
  // Angles beyond the joint's range are clamped to it; only what no number of degrees would be, or
  // is no number, is refused.
  static constexpr double kMaxAngleRad = 1e6;
  static constexpr double kMaxSpeedRadps = 100;
  static constexpr double kMaxWalkMps = 10;
  static constexpr double kMaxTurnRadps = 100;
  static constexpr int64_t kMaxOffsetNs = 10'000'000'000;
};

// "joints[0].targets[1].angle_rad: found nan, expected a number from -1e+06 to 1e+06" for the first
// field that is not a finite number in its range, nothing for a good command.
std::optional<std::string> invalid_field(const RobotCommand& command);

}  // namespace seam
