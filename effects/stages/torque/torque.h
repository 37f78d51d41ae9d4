// Stage `joint`, a servo that has torque: angle and rate are a state that drive, load and friction
// accelerate.
//
//   duty  = clamp(gain kp (command - q) - damping w, -max_duty, +max_duty)
//   drive = clamp(strength (stall duty voltage - back_emf w), -limit, +limit)
//   net   = drive - load, load = gravity cos(q - level) + asymmetry - cogging sin(waves q + phase)
//   dw/dt = net - viscous w - dry friction against the motion,
//   dry   = coulomb + stribeck exp(-|w| / stribeck_speed) + load_fraction |net| +
//           carried_fraction |drive + load|
//
// Between changes of the command, of a clamp, or of a sign the right side is analytic. There the
// motion is a Taylor series in time, whose coefficients follow from the equation by recurrence; the
// ends of such a piece are roots of polynomials. So the joint stops where it stops, to the last
// bits: it cannot chatter about rest, and dry friction holds it there as long as it can.
#pragma once

#include <algorithm>
#include <limits>

namespace seam::effects {

// What the torque effects of a model add up to, in angular acceleration of the joint.
struct TorqueModel {
  bool present = false;  // The servo has torque; else it goes to its command by kinematic rules.
  double stall_rad_per_s2 = 0;
  double back_emf_per_s = 0;
  double gain = 0;       // Duty a radian of error, times kp.
  double damping_s = 0;  // Duty a rad/s.
  double max_duty = 1;
  double limit_rad_per_s2 = std::numeric_limits<double>::infinity();  // Of |drive|.
  double gravity_rad_per_s2 = 0;
  double level_rad = 0;  // Where the load is level: gravity pulls most.
  // By how much dry friction is more than its mean in motions to larger angles, and less in others:
  // the same as a load that is constant.
  double asymmetry_rad_per_s2 = 0;
  // Of the magnets on the iron's teeth: a torque in a wave over the turn, whatever the drive does.
  double cogging_rad_per_s2 = 0;
  double cogging_per_turn = 1;
  double cogging_rad = 0;      // Its phase.
  double weakening_per_k = 0;  // Growth of the windings' resistance for each kelvin.
  double viscous_per_s = 0;
  double coulomb_rad_per_s2 = 0;
  double stribeck_rad_per_s2 = 0;
  double stribeck_rad_per_s = 0;
  double load_fraction = 0;     // Of what drive and load leave.
  double carried_fraction = 0;  // Of what the gears carry between drive and load.

  // What is left of the drive where the motor is so much warmer than the reference.
  double strength_at(double warmer_k) const {
    constexpr double kLeastResistance = 0.1;  // What no motor has: a fit may try it.
    return 1 / std::max(kLeastResistance, 1 + weakening_per_k * warmer_k);
  }
};

// What the magnets push with at this angle.
double cogging_at(const TorqueModel& motor, double q_rad);

// Friction that may hold a joint at rest.
bool has_dry_friction(const TorqueModel& motor);

// What acts on the motor for a while. The command may move at a constant rate.
struct MotorInput {
  double command_rad = 0;
  double command_radps = 0;
  double kp = 1;        // Of the log's column.
  double voltage = 1;   // In units of its median.
  double strength = 1;  // Of the drive, in units of its own at the reference temperature.
  bool enabled = true;  // False: no drive and no back-EMF.
  double t_s = 0;       // Now; formulas read it.
};

struct MotorState {
  double q_rad = 0;
  double w_radps = 0;
};

// Moves for at most `dt_s`, to the first turning point at the latest, so that play behind the motor
// sees monotone motion; returns how long it moved. Angle and rate err by less than 1e-9 rad and
// 1e-7 rad/s over a row of a log. A state that is no number says that the equation is too stiff.
double advance_motor(const TorqueModel& motor, const MotorInput& input, double dt_s,
                     MotorState& state);

// What hangs on the joint, for angles whose cosine and sine are at hand.
class HangingLoad {
 public:
  explicit HangingLoad(const TorqueModel& motor);
  double at(double q_rad, double cos_q, double sin_q) const {
    const double still = along_cos_ * cos_q + along_sin_ * sin_q + constant_;
    return motor_.cogging_rad_per_s2 == 0 ? still : still - cogging_at(motor_, q_rad);
  }

 private:
  const TorqueModel& motor_;
  double along_cos_, along_sin_;  // Of gravity.
  double constant_;
};

// What the motor gives at rest for the controller's duty, before its limits; 0 where it is off.
double drive_at_rest(const TorqueModel& motor, const MotorInput& input, const MotorState& state);

// What the motor gives now, back-EMF and limits included.
double drive_of(const TorqueModel& motor, const MotorInput& input, const MotorState& state);

// Angular acceleration now, under this load. A joint slower than `rest_radps` counts as at rest:
// dry friction holds it as long as it can.
double motor_acceleration(const TorqueModel& motor, const MotorInput& input,
                          const MotorState& state, double load_rad_per_s2, double rest_radps);

}  // namespace seam::effects
