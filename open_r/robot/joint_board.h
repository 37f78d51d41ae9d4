// Joints as OPEN-R sees them: power, gains, what was commanded and measured. A joint follows
// commands while motor power is on and its gain is enabled and set.
#pragma once

#include <optional>
#include <vector>

#include "open_r/robot/leg_motion.h"
#include "open_r/robot/primitives.h"
#include "robot_sdk/robot.h"

namespace seam::open_r {

inline constexpr int64_t kFrameNs = 8'000'000;

class JointBoard {
 public:
  explicit JointBoard(const RobotDesign& design);

  // ---- Power and gains ----
  void set_power(bool on) { power_ = on; }
  bool power() const { return power_; }
  bool is_joint(int primitive) const;
  void enable_gain(int primitive, bool enabled);
  // False while the gain is not enabled.
  bool set_gain(int primitive, const JointGain& gain);
  bool gain_enabled(int primitive) const { return state(primitive).enabled; }
  const JointGain& gain(int primitive) const { return state(primitive).gain; }
  void set_default_gain(int primitive, const JointGain& gain);
  const JointGain& default_gain(int primitive) const { return state(primitive).default_gain; }

  // ---- What is measured ----
  void sense(const sdk::JointAngles& encoders);
  OJointValue value(int primitive) const;

  // ---- What is commanded ----
  // Where a joint is to be at the end of this frame.
  void command(int primitive, slongword micro_rad);
  struct Orders {
    std::vector<sdk::JointTarget> targets;
    std::optional<sdk::Walk> walk;  // How the body goes with the legs.
  };
  Orders take_orders();
  // Commands that went nowhere, and why, once for each reason.
  std::vector<std::string> take_warnings();

 private:
  struct State {
    JointGain gain, default_gain;
    bool enabled = false, gain_set = false;
    double measured_rad = 0;
    slongword reference = 0;             // Micro-radians.
    bool commanded = false;              // Ever.
    int without_gain = 0;                // Frames for which it was commanded in vain.
    std::optional<double> target_rad;    // Of the frame that is being made.
    std::optional<double> expected_rad;  // Where it is if the servo followed.
  };
  const State& state(int primitive) const { return states_[static_cast<size_t>(primitive)]; }
  State& state(int primitive) { return states_[static_cast<size_t>(primitive)]; }
  void add_walk(Orders& orders);
  void warn(const std::string& line);

  const RobotDesign& design_;
  std::vector<State> states_;
  bool power_ = false;
  std::optional<LegAngles> legs_before_;  // Since the legs are commanded.
  bool walking_ = false;
  std::vector<std::string> warnings_, warned_;
};

}  // namespace seam::open_r
