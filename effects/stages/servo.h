// Stage `joint`, from commands: how a servo moves its joint. The order is that of the definitions:
// latency, servo (lag, speed and acceleration limits, stiction, or a motor with torque: torque.h),
// backlash, elasticity (elastic.h), ripple, sag, formulas, in a log the encoder. Without torque,
// between changes of the command the motion has a closed form, so the same solution predicts a
// log's rows and moves the simulator's joints in continuous time.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "effects/model.h"
#include "effects/stages/torque/elastic.h"
#include "effects/stages/torque/torque.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

// A wave of the gears over the joint's angle.
struct GearRipple {
  double amplitude_rad = 0;
  double per_turn = 0;
  double phase_rad = 0;

  double at(double q_rad) const;
  double slope_at(double q_rad) const;
};

// What a log shows of the motor's torque: a current that is turned into it.
struct EffortReading {
  double inertia_kg_m2 = 0;  // Of joint and load; 0: unknown.
  double scale = 0;          // Shown is this share more than the drive gives,
  double offset_nm = 0;      // and this besides.

  double of_torque(double torque_nm) const { return (1 + scale) * torque_nm + offset_nm; }
};

// What a formula of the torque reads.
struct PushedMotor {
  double q_rad = 0;
  double w_radps = 0;
  double command_rad = 0;
  double t_s = 0;
  double drive_rad_per_s2 = 0;  // At rest.
};

// What the servo effects of a model add up to.
struct ServoModel {
  double latency_s = 0;  // A command acts this much after its time.
  double tau_s = 0;      // Wanted rate = (command - q) / tau; 0: at the command at once.
  double rad_per_s = std::numeric_limits<double>::infinity();   // Limit of |rate|.
  double rad_per_s2 = std::numeric_limits<double>::infinity();  // Limit of |acceleration|.
  double dead_band_rad = 0;  // The joint rests while |command - q| is below this.
  double backlash_rad = 0;   // Play between motor and load.
  double sag_rad = 0;        // The load hangs by sag * cos(q - level).
  double level_rad = 0;
  GearRipple ripple;     // Before the load sags.
  ElasticJoint elastic;  // Behind the play, before ripple and sag.
  TorqueModel torque;    // Where present it moves the motor instead of the rules above.
  EffortReading effort;  // Of its drive; it moves nothing.
  // Torque formulas: angular acceleration (rad/s^2) that each adds to the motor's.
  std::vector<std::function<double(const PushedMotor&)>> pushes;
  // Joint formulas (expression effects), in order: their result replaces the angle.
  std::vector<ModelEffect> formulas;
};

// The part of a model that turns commands into angles.
ServoModel servo_of(const Model& model);

// The motor side of one joint: angle and rate, and where the load stands in the play.
struct ServoState {
  double motor_rad = 0;
  double motor_radps = 0;
  double load_rad = 0;   // Behind the play, before what is elastic, and sag.
  ElasticState elastic;  // The load's, where it hangs on a spring.
};

// At rest with the joint (behind backlash and sag) at this angle, the play centred.
ServoState servo_at_rest(const ServoModel& servo, double joint_rad);

// What the formulas add to the motor's acceleration now.
double push_on(const ServoModel& servo, const MotorInput& input, const MotorState& state);

// Moves a servo with torque for `dt_s`. Formulas push evenly over steps of 2 ms, as at their
// middle: of a motion with a time constant of 20 ms these leave less than 1e-3.
void advance_servo(const ServoModel& servo, MotorInput input, double dt_s, ServoState& state);

// Moves one without for `dt_s` under a command that holds. Exact: a sequence of closed-form pieces.
void advance_servo(const ServoModel& servo, double command_rad, double dt_s, ServoState& state);

// Moves either, and the load that hangs on it elastically, for `dt_s`; of `input` rules of
// kinematics see the command alone.
void advance_joint(const ServoModel& servo, const MotorInput& input, double dt_s,
                   ServoState& state);

// The joint's angle: behind backlash, elasticity, ripple and sag, before formulas.
double joint_angle(const ServoModel& servo, const ServoState& state);

// The load of a play of this width that follows a motor moving monotonically to `motor_rad`.
double follow_play(double width_rad, double motor_rad, double load_rad);

// Commands with times and the joint's answer, in continuous time: commands are queued by their own
// times, act `latency` later, and the state moves forward only.
class Servo {
 public:
  // At rest at `joint_rad` from `t_s` on, until the first command acts.
  Servo(ServoModel model, double t_s, double joint_rad);

  // A command given at `t_s`, not before earlier ones; `enabled` false: from then on (after the
  // latency) no command acts, and a motor has no torque. `kp`: the gain's factor of a motor.
  void command(double t_s, double command_rad, bool enabled = true, double kp = 1);

  // The joint was moving when the log began, under a command that acts already.
  void begin_moving(double radps, double command_rad, bool enabled, double kp);

  // The supply of a motor from now on, in units of its median.
  void set_voltage(double ratio) { input_.voltage = ratio; }

  // By how much a motor is warmer from now on than the reference.
  void set_warmer(double warmer_k) { input_.strength = model_.torque.strength_at(warmer_k); }

  // Moves a motor by this much at once, and pushes it from now on: what small changes make of a
  // motion shows where one goes on so and another as it was.
  void nudge(double rad, double radps, double rad_per_s2);

  // When the last command acts that has not yet and does so before `until_s`; NaN: there is none.
  double last_acting(double until_s) const;
  // The commands that act until then act so much later.
  void shift_commands(double until_s, double by_s);

  // Moves to `t_s`, to just before commands that act at that very time (within a nanosecond).
  void advance_to(double t_s);

  double joint_rad() const { return joint_angle(model_, state_); }
  const ServoState& state() const { return state_; }
  // What a motor gives, in acceleration of its joint. One that no command has reached holds its
  // load.
  double drive_rad_per_s2() const {
    const MotorState motor{state_.motor_rad, state_.motor_radps};
    return begun_ ? drive_of(model_.torque, input_, motor)
                  : HangingLoad(model_.torque)
                        .at(motor.q_rad, maths::cos(motor.q_rad), maths::sin(motor.q_rad));
  }
  double acting_command_rad() const { return input_.command_rad; }
  const ServoModel& model() const { return model_; }

 private:
  void rest(double dt_s);

  struct Pending {
    double acts_s;
    double command_rad;
    bool enabled;
    double kp;
  };
  ServoModel model_;
  ServoState state_;
  double now_s_;
  bool begun_ = false;          // Some command has acted.
  MotorInput input_;            // What acts now.
  std::vector<Pending> queue_;  // Ascending in time; from next_ on not yet acting.
  size_t next_ = 0;
};

}  // namespace seam::effects
