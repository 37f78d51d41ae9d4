#include "sim_core/body/joint_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace seam {
namespace {

// An ERS-210's; kinematics.h has the axes.
std::string head_or_leg_direction(size_t joint) {
  switch (joint) {
    case kTilt:
      return "head up";
    case kPan:
      return "head to its left";
    case kRoll:
      return "about the axis forwards: left side up";
    default:
      break;
  }
  const size_t in_leg = (joint - kHeadJoints) % kJointsALeg;
  const bool front = joint < static_cast<size_t>(kLeftHindRotator);
  if (in_leg == 1) return "leg outwards";
  const char* part = in_leg == 0 ? "leg" : "paw";
  return fmt::format("{} {}", part, front ? "forwards" : "backwards");
}

const TreeLink* moved_link(const RobotBody& body, size_t joint) {
  return body.tree.present() ? &body.tree.joint(joint) : nullptr;
}

// Angles of more than this, but of no more than a full turn in degrees, look like degrees.
constexpr double kFewestDegrees = 5, kMostDegrees = 400;

std::string degrees_of(double angle_rad) {
  return fmt::format("{:.1f}", angle_rad * 180 / std::numbers::pi);
}

}  // namespace

std::string joint_unit(const RobotBody& body, size_t joint) {
  const TreeLink* link = moved_link(body, joint);
  return link != nullptr && link->motion == JointMotion::slide ? "m" : "rad";
}

std::vector<std::string> joint_field_names(const RobotBody& body) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (size_t joint = 0; joint < body.joint_count(); ++joint) {
    std::string name = fmt::format("{}_{}", body.joint_name(joint), joint_unit(body, joint));
    std::replace(name.begin(), name.end(), '.', '_');
    while (!taken.insert(name).second) name += "_";
    names.push_back(std::move(name));
  }
  return names;
}

std::string joint_direction(const RobotBody& body, size_t joint) {
  const TreeLink* link = moved_link(body, joint);
  if (link == nullptr) return head_or_leg_direction(joint);
  return fmt::format("{} ({:g}, {:g}, {:g}) of the joint's frame{}",
                     link->motion == JointMotion::slide ? "along" : "about", link->axis.x,
                     link->axis.y, link->axis.z,
                     link->motion == JointMotion::slide ? "" : ", right-handed");
}

std::optional<std::string> out_of_range_text(const RobotBody& body, size_t joint, double value) {
  const JointLimits& limits = body.joints[joint];
  if (value >= limits.min_rad && value <= limits.max_rad) return std::nullopt;
  const std::string unit = joint_unit(body, joint);
  std::string text = fmt::format(
      "{}: {:g} {} is out of its range, {:.4g} to {:.4g} {}, and is "
      "clamped to it",
      body.joint_name(joint), value, unit, limits.min_rad, limits.max_rad, unit);
  const double size = std::abs(value);
  if (unit == "rad" && size >= kFewestDegrees && size <= kMostDegrees)
    text += fmt::format("; did you mean degrees? {:g} degrees are {:.4g} rad", value,
                        value * std::numbers::pi / 180);
  return text;
}

std::string joints_text(const RobotBody& body) {
  std::string text = fmt::format("{}: {} joints\n", body.name, body.joint_count());
  for (size_t j = 0; j < body.joint_count(); ++j) {
    const JointLimits& limits = body.joints[j];
    const std::string unit = joint_unit(body, j);
    text +=
        fmt::format("{:>3}  {:<22} {:>8.4g} to {:<8.4g} {:<4} at most {:.3g} {}/s; positive: {}\n",
                    j, body.joint_name(j), limits.min_rad, limits.max_rad, unit, limits.speed_radps,
                    unit, joint_direction(body, j));
  }
  return text;
}

std::string joints_markdown(const RobotBody& body) {
  std::string text =
      "| Number | Joint | Unit | Range | In degrees | Top speed | Positive |\n"
      "|---|---|---|---|---|---|---|\n";
  for (size_t j = 0; j < body.joint_count(); ++j) {
    const JointLimits& limits = body.joints[j];
    const std::string unit = joint_unit(body, j);
    const std::string degrees =
        unit == "rad" ? degrees_of(limits.min_rad) + " to " + degrees_of(limits.max_rad) : "";
    text += fmt::format("| {} | `{}` | {} | {:.4g} to {:.4g} | {} | {:.3g} {}/s | {} |\n", j,
                        body.joint_name(j), unit, limits.min_rad, limits.max_rad, degrees,
                        limits.speed_radps, unit, joint_direction(body, j));
  }
  return text;
}

}  // namespace seam
