#include "sim_core/body/command.h"

#include <fmt/format.h>

#include <array>

namespace seam {
namespace {

constexpr std::array<const char*, kKicks> kKickNames = {
    "none", "leg_forward", "leg_left", "leg_right", "head_left", "head_right", "grab", "release"};

std::optional<std::string> out_of_range(const std::string& field, double value, double min,
                                        double max) {
  if (value >= min && value <= max) return std::nullopt;  // False for NaN.
  return fmt::format("{}: found {}, expected a number from {} to {}", field, value, min, max);
}

std::optional<std::string> invalid_target(const std::string& field, const JointTarget& target) {
  using Limits = CommandLimits;
  if (target.joint < 0 || target.joint >= kMostJoints) {
    return fmt::format("{}.joint: found {}, expected a joint from 0 to {}", field, target.joint,
                       kMostJoints - 1);
  }
  const double angle = Limits::kMaxAngleRad;
  if (auto bad = out_of_range(field + ".angle_rad", target.angle_rad, -angle, angle)) return bad;
  return out_of_range(field + ".speed_radps", target.speed_radps, 0, Limits::kMaxSpeedRadps);
}

std::optional<std::string> invalid_frames(const std::vector<JointFrame>& frames) {
  using Limits = CommandLimits;
  if (frames.size() > Limits::kMaxJointFrames) {
    return fmt::format("joints: found {} frames, expected at most {}", frames.size(),
                       Limits::kMaxJointFrames);
  }
  int64_t earliest_ns = 0;
  for (size_t f = 0; f < frames.size(); ++f) {
    const std::string field = fmt::format("joints[{}]", f);
    const int64_t offset_ns = frames[f].offset.ns();
    if (offset_ns < earliest_ns || offset_ns > Limits::kMaxOffsetNs) {
      return fmt::format("{}.offset: found {} ns, expected from {} to {} ns", field, offset_ns,
                         earliest_ns, Limits::kMaxOffsetNs);
    }
    earliest_ns = offset_ns;
    if (frames[f].targets.size() > Limits::kMaxTargetsAFrame) {
      return fmt::format("{}.targets: found {}, expected at most {}", field,
                         frames[f].targets.size(), Limits::kMaxTargetsAFrame);
    }
    for (size_t t = 0; t < frames[f].targets.size(); ++t) {
      if (auto bad = invalid_target(fmt::format("{}.targets[{}]", field, t), frames[f].targets[t]))
        return bad;
    }
  }
  return std::nullopt;
}

}  // namespace

std::string to_string(Kick kick) {
  return kKickNames.at(static_cast<size_t>(kick));
}

std::optional<std::string> invalid_field(const RobotCommand& command) {
  using Limits = CommandLimits;
  if (auto bad = invalid_frames(command.joints)) return bad;
  if (command.walk) {
    const double v = Limits::kMaxWalkMps;
    if (auto bad = out_of_range("walk.vx_mps", command.walk->vx_mps, -v, v)) return bad;
    if (auto bad = out_of_range("walk.vy_mps", command.walk->vy_mps, -v, v)) return bad;
    const double omega = Limits::kMaxTurnRadps;
    if (auto bad = out_of_range("walk.omega_radps", command.walk->omega_radps, -omega, omega))
      return bad;
  }
  if (static_cast<size_t>(command.kick) >= kKicks) {
    return fmt::format("kick: found {}, expected from 0 to {}", static_cast<int>(command.kick),
                       kKicks - 1);
  }
  return std::nullopt;
}

}  // namespace seam
