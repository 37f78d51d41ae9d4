#include "open_r/robot/joint_board.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace seam::open_r {
namespace {

constexpr double kFrame_s = 0.008;
constexpr int kFirstLegJoint = 3, kLegJoints = 12;
constexpr int kPatience = 125;  // Frames of commands to a joint without a gain: a second.

slongword micro_radians(double rad) {
  return static_cast<slongword>(std::lround(rad * 1e6));
}

// The ten bits that a converter would give.
word signal_of(const Primitive& primitive, double rad) {
  const double share = (rad - primitive.min_rad) / (primitive.max_rad - primitive.min_rad);
  return static_cast<word>(std::lround(std::clamp(share, 0.0, 1.0) * 1023));
}

}  // namespace

JointBoard::JointBoard(const RobotDesign& design)
    : design_(design), states_(design.primitives.size()) {
  for (size_t i = 0; i < states_.size(); ++i) states_[i].default_gain = design.primitives[i].gain;
}

bool JointBoard::is_joint(int primitive) const {
  return primitive >= 0 && static_cast<size_t>(primitive) < states_.size() &&
         design_.primitives[static_cast<size_t>(primitive)].quantity == Quantity::joint;
}

void JointBoard::enable_gain(int primitive, bool enabled) {
  State& joint = state(primitive);
  joint.enabled = enabled;
  if (!enabled) joint.gain = {}, joint.gain_set = false;
}

bool JointBoard::set_gain(int primitive, const JointGain& gain) {
  State& joint = state(primitive);
  if (!joint.enabled) return false;
  joint.gain = gain;
  joint.gain_set = true;
  return true;
}

void JointBoard::set_default_gain(int primitive, const JointGain& gain) {
  state(primitive).default_gain = gain;
}

void JointBoard::sense(const sdk::JointAngles& encoders) {
  for (size_t i = 0; i < states_.size(); ++i) {
    const int joint = design_.primitives[i].index;
    if (design_.primitives[i].quantity != Quantity::joint || joint < 0) continue;
    if (static_cast<size_t>(joint) >= encoders.angles_rad.size()) continue;
    states_[i].measured_rad = encoders.angles_rad[static_cast<size_t>(joint)];
    if (!states_[i].commanded) states_[i].reference = micro_radians(states_[i].measured_rad);
  }
}

OJointValue JointBoard::value(int primitive) const {
  const Primitive& joint = design_.primitives[static_cast<size_t>(primitive)];
  const State& s = state(primitive);
  return {micro_radians(s.measured_rad), signal_of(joint, s.measured_rad), 0, s.reference,
          signal_of(joint, s.reference * 1e-6)};
}

void JointBoard::command(int primitive, slongword micro_rad) {
  const Primitive& joint = design_.primitives[static_cast<size_t>(primitive)];
  State& s = state(primitive);
  s.reference = micro_rad;
  s.commanded = true;
  if (!power_)
    return warn(
        "joints are commanded while motor power is off: they stay. An object calls "
        "OPENR::SetMotorPower(opowerON)");
  if (!s.gain_set) {
    // Programs command where a joint is before they set its gain.
    if (++s.without_gain == kPatience)
      warn(std::string(joint.locator) +
           " is commanded without a gain: it stays. An object calls OPENR::EnableJointGain() and "
           "OPENR::SetJointGain() or SetDefaultJointGain()");
    return;
  }
  s.target_rad = std::clamp(micro_rad * 1e-6, joint.min_rad, joint.max_rad);
}

JointBoard::Orders JointBoard::take_orders() {
  Orders orders;
  for (size_t i = 0; i < states_.size(); ++i) {
    State& s = states_[i];
    if (!s.target_rad) continue;
    const Primitive& joint = design_.primitives[i];
    const double target = *std::exchange(s.target_rad, std::nullopt);
    if (joint.index < 0) {
      s.measured_rad = target;
      continue;
    }
    // Evenly through the frame, as far as the servo's top speed carries.
    const double from = s.expected_rad.value_or(s.measured_rad);
    const double most = joint.speed_radps * kFrame_s, way = target - from;
    s.expected_rad = from + std::clamp(way, -most, most);
    const double speed = std::abs(way) < most ? std::abs(way) / kFrame_s : 0;
    orders.targets.push_back({.joint = joint.index, .angle_rad = target, .max_speed_rad_s = speed});
  }
  add_walk(orders);
  return orders;
}

// The body goes as the paws that stand push it. A walk without targets of the legs would hand them
// back to the simulator's own gait, so that it always comes with all of them.
void JointBoard::add_walk(Orders& orders) {
  const bool legs = std::any_of(orders.targets.begin(), orders.targets.end(), [](const auto& t) {
    return t.joint >= kFirstLegJoint && t.joint < kFirstLegJoint + kLegJoints;
  });
  if (!legs && !walking_) return;
  LegAngles now{};
  for (size_t i = 0; i < states_.size(); ++i) {
    const int leg = design_.primitives[i].index - kFirstLegJoint;
    if (design_.primitives[i].quantity != Quantity::joint || leg < 0) continue;
    now[static_cast<size_t>(leg)] = states_[i].expected_rad.value_or(states_[i].measured_rad);
  }
  const BodyMotion motion =
      legs && legs_before_ ? motion_of_legs(*legs_before_, now, kFrame_s) : BodyMotion{};
  legs_before_ = now;
  walking_ = legs;
  orders.walk = {motion.vx_m_s, motion.vy_m_s, motion.omega_rad_s};
  for (int leg = 0; leg < kLegJoints; ++leg) {
    const int number = kFirstLegJoint + leg;
    if (std::none_of(orders.targets.begin(), orders.targets.end(),
                     [&](const auto& t) { return t.joint == number; }))
      orders.targets.push_back(
          {.joint = number, .angle_rad = now[static_cast<size_t>(leg)], .max_speed_rad_s = 0});
  }
}

void JointBoard::warn(const std::string& line) {
  if (std::find(warned_.begin(), warned_.end(), line) != warned_.end()) return;
  warned_.push_back(line);
  warnings_.push_back(line);
}

std::vector<std::string> JointBoard::take_warnings() {
  return std::exchange(warnings_, {});
}

}  // namespace seam::open_r
