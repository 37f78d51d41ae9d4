#include "effects/stages/servo.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

// Angles nearer than this (radians) are the same: far below any encoder's step.
constexpr double kSameAngle_rad = 1e-13;
constexpr double kSameTime_s = 1e-9;
// Turning points of a motor in one advance: more stand for an equation that no servo has.
constexpr int kMostTurns = 2000;

// Moves the motor along a piece without a turning point and lets the load follow.
void settle_load(const ServoModel& servo, ServoState& state) {
  state.load_rad = follow_play(servo.backlash_rad, state.motor_rad, state.load_rad);
}

// Without an acceleration limit the rate is a function of the angle: clamp((command - q) / tau).
void advance_first_order(const ServoModel& servo, double command_rad, double dt_s,
                         ServoState& state) {
  const double error = command_rad - state.motor_rad;
  const double sign = error < 0 ? -1 : 1;
  double distance = std::abs(error);
  // The joint stops at the edge of the dead band, except a servo without lag or limit, which is at
  // its command at once.
  const double rest = servo.dead_band_rad;
  const bool at_once = servo.tau_s <= 0 && !std::isfinite(servo.rad_per_s);
  double left_s = dt_s;
  double end_rate = 0;
  if (distance < rest || distance == 0) {
    state.motor_radps = 0;
    return;
  }
  if (at_once) {
    distance = 0;
  } else {
    const double knee =
        std::max(rest, servo.tau_s * servo.rad_per_s);  // Above: at the speed limit.
    if (distance > knee) {
      const double ramp_s = (distance - knee) / servo.rad_per_s;
      const bool whole = ramp_s >= left_s;
      distance = whole ? distance - servo.rad_per_s * left_s : knee;
      left_s = whole ? 0 : left_s - ramp_s;
      end_rate = whole ? servo.rad_per_s : 0;
    }
    if (left_s > 0 && servo.tau_s > 0) {
      distance = std::max(distance * maths::exp(-left_s / servo.tau_s), rest);
      end_rate = distance > rest ? distance / servo.tau_s : 0;
    }
  }
  state.motor_rad = command_rad - sign * distance;
  state.motor_radps = sign * end_rate;
  settle_load(servo, state);
}

// With an acceleration limit a the wanted rate at distance e from the command is
//   w(e) = min(e / tau, speed limit, sqrt(2 a e)),
// the last so that braking at a stops at the command; the rate follows w with |dv/dt| <= a. In
// coordinates with the command ahead (e >= 0, v the rate towards it) each piece is closed: speeding
// up or braking at a until w is met, cruising at the limit, braking along sqrt(2 a e), or, where
// the lag asks for less than a (e <= a tau^2), an exponential.
struct SecondOrder {
  const ServoModel& servo;
  double a;
  double e;  // Distance to the command, kept >= 0.
  double v;  // Rate towards it.

  double lag_curve(double at) const { return servo.tau_s > 0 ? at / servo.tau_s : 1e300; }
  double braking_curve(double at) const { return std::sqrt(2 * a * std::max(at, 0.0)); }
  double wanted() const { return std::min({lag_curve(e), servo.rad_per_s, braking_curve(e)}); }

  // The first time after `from_s` at which v + s a t meets w(e(t)), s = +1 speeding up or -1
  // braking; infinite where it never does.
  double time_to_wanted(double s, double from_s = 0) const {
    double first = std::numeric_limits<double>::infinity();
    const auto offer = [&](double t) {
      if (t > from_s && t < first) first = t;
    };
    if (std::isfinite(servo.rad_per_s)) offer(s * (servo.rad_per_s - v) / a);
    if (servo.tau_s > 0) {
      // v + s a t = (e - v t - s a t^2 / 2) / tau.
      const double qa = 0.5 * s * a, qb = v + s * a * servo.tau_s, qc = v * servo.tau_s - e;
      const double root = qb * qb - 4 * qa * qc;
      if (root >= 0) {
        const double q = -0.5 * (qb + std::copysign(std::sqrt(root), qb));
        offer(q / qa);
        if (q != 0) offer(qc / q);
      }
    }
    if (s > 0) {
      // (v + a t)^2 = 2 a (e - v t - a t^2 / 2): a^2 t^2 + 2 a v t + v^2 / 2 - a e = 0.
      const double root = 0.5 * v * v + a * e;
      offer((-v + std::sqrt(root)) / a);
    }
    return first;
  }

  void coast(double s, double t) {
    e -= v * t + 0.5 * s * a * t * t;
    v += s * a * t;
  }
};

// One piece of at most `left_s`; returns how long it took.
double advance_piece(SecondOrder& motion, double left_s) {
  constexpr double kOnCurve = 1e-11;
  const double wanted = motion.wanted();
  const double slack = kOnCurve * std::max(1.0, wanted);
  const double a = motion.a;
  if (std::abs(motion.v - wanted) > slack) {
    const double s = motion.v < wanted ? 1 : -1;
    double t = std::min(left_s, motion.time_to_wanted(s));
    // A turning point ends the piece, so that play sees monotone motion.
    if (s * motion.v < 0) t = std::min(t, std::abs(motion.v) / a);
    if (s < 0 && motion.v > 0) {
      // Braking too late: where the command is passed the piece ends.
      const double root = motion.v * motion.v - 2 * a * motion.e;
      if (root >= 0) t = std::min(t, 2 * motion.e / (motion.v + std::sqrt(root)));
    }
    motion.coast(s, t);
    if (s * motion.v < 0 && std::abs(motion.v) < kOnCurve) motion.v = 0;
    return t;
  }
  // On the curve of wanted rates.
  const double tau = motion.servo.tau_s;
  const double limit = motion.servo.rad_per_s;
  // Above this distance the speed limit is the slowest curve: cruise down to it.
  const double knee = std::max(tau * limit, 0.5 * limit * limit / a);
  if (motion.e > knee + kSameAngle_rad) {
    const double t = std::min(left_s, (motion.e - knee) / limit);
    motion.e -= limit * t;
    motion.v = limit;
    return t;
  }
  if (tau > 0 && motion.e <= a * tau * tau) {
    motion.e *= maths::exp(-left_s / tau);
    motion.v = motion.e / tau;
    return left_s;
  }
  if (motion.lag_curve(motion.e) < motion.braking_curve(motion.e)) {
    // The lag's curve asks for more than a: brake at a, above the curve, until it is met again.
    const double t = std::min({left_s, motion.time_to_wanted(-1, kSameTime_s), motion.v / a});
    motion.coast(-1, t);
    return t;
  }
  // Brake at a along v = sqrt(2 a e), down to the command.
  const double t = std::min(left_s, motion.v / a);
  motion.v = t < left_s ? 0 : std::max(0.0, motion.v - a * t);
  motion.e = 0.5 * motion.v * motion.v / a;
  return t;
}

void advance_second_order(const ServoModel& servo, double command_rad, double dt_s,
                          ServoState& state) {
  double left_s = dt_s;
  // Each interval has a few pieces; the cap only guards against rounding at a curve's end.
  for (int piece = 0; piece < 100 && left_s > 0; ++piece) {
    const double error = command_rad - state.motor_rad;
    const bool there = std::abs(error) <= kSameAngle_rad;
    const bool arrived = there && std::abs(state.motor_radps) < 1e-6;
    // A joint that passes its command has it behind.
    const double sign = there ? (state.motor_radps > 0 ? -1 : 1) : (error < 0 ? -1 : 1);
    if (arrived || std::abs(error) < servo.dead_band_rad) {
      if (arrived) state.motor_rad = command_rad;
      state.motor_radps = 0;
      break;
    }
    SecondOrder motion{servo, servo.rad_per_s2, std::abs(error), sign * state.motor_radps};
    const double band_e = motion.e;
    double took = advance_piece(motion, left_s);
    if (servo.dead_band_rad > 0 && motion.e < servo.dead_band_rad &&
        band_e >= servo.dead_band_rad) {
      motion.e = servo.dead_band_rad * (1 - 1e-15);
      motion.v = 0;
      took = left_s;
    }
    state.motor_rad = command_rad - sign * motion.e;
    state.motor_radps = sign * motion.v;
    settle_load(servo, state);
    left_s -= took;
  }
}

}  // namespace

double follow_play(double width_rad, double motor_rad, double load_rad) {
  if (width_rad <= 0) return motor_rad;
  return std::clamp(load_rad, motor_rad - 0.5 * width_rad, motor_rad + 0.5 * width_rad);
}

double GearRipple::at(double q_rad) const {
  return amplitude_rad == 0 ? 0 : amplitude_rad * maths::sin(per_turn * q_rad + phase_rad);
}

double GearRipple::slope_at(double q_rad) const {
  return amplitude_rad == 0 ? 0
                            : amplitude_rad * per_turn * maths::cos(per_turn * q_rad + phase_rad);
}

ServoModel servo_of(const Model& model) {
  ServoModel servo;
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->servo) effect.definition->servo(effect.values(), servo);
    if (effect.definition->joint_map) servo.formulas.push_back(effect);
  }
  return servo;
}

ServoState servo_at_rest(const ServoModel& servo, double joint_rad) {
  // Newton's method, where sag and ripple let the joint's angle increase with the motor's.
  double q = joint_rad;
  for (int step = 0; step < 20 && (servo.sag_rad != 0 || servo.ripple.amplitude_rad != 0); ++step) {
    const double turned = q + servo.ripple.at(q);
    const double miss = turned - servo.sag_rad * maths::cos(turned - servo.level_rad) - joint_rad;
    const double slope =
        (1 + servo.sag_rad * maths::sin(turned - servo.level_rad)) * (1 + servo.ripple.slope_at(q));
    if (!(slope > 0)) break;
    q -= miss / slope;
    if (std::abs(miss) < 1e-15) break;
  }
  return {.motor_rad = q, .motor_radps = 0, .load_rad = q, .elastic = {.q_rad = q}};
}

void advance_servo(const ServoModel& servo, double command_rad, double dt_s, ServoState& state) {
  if (dt_s <= 0) return;
  if (std::isfinite(servo.rad_per_s2)) {
    advance_second_order(servo, command_rad, dt_s, state);
  } else {
    advance_first_order(servo, command_rad, dt_s, state);
  }
}

namespace {

// What acts so much later, the command having moved on.
MotorInput later(MotorInput input, double by_s) {
  input.command_rad += input.command_radps * by_s;
  input.t_s += by_s;
  return input;
}

void advance_unpushed(const ServoModel& servo, const TorqueModel& torque, const MotorInput& input,
                      double dt_s, ServoState& state) {
  MotorState motor{state.motor_rad, state.motor_radps};
  int turns = 0;
  for (double done_s = 0; done_s < dt_s; ++turns) {
    done_s += advance_motor(torque, later(input, done_s), dt_s - done_s, motor);
    state.motor_rad = motor.q_rad, state.motor_radps = motor.w_radps;
    settle_load(servo, state);
    if (turns > kMostTurns) state.motor_rad = state.load_rad = NAN;
    if (!std::isfinite(state.motor_rad)) return;
  }
}

}  // namespace

double push_on(const ServoModel& servo, const MotorInput& input, const MotorState& state) {
  if (servo.pushes.empty()) return 0;
  const PushedMotor at{.q_rad = state.q_rad,
                       .w_radps = state.w_radps,
                       .command_rad = input.command_rad,
                       .t_s = input.t_s,
                       .drive_rad_per_s2 = drive_at_rest(servo.torque, input, state)};
  double sum = 0;
  for (const auto& push : servo.pushes) sum += push(at);
  return sum;
}

void advance_servo(const ServoModel& servo, MotorInput input, double dt_s, ServoState& state) {
  if (servo.pushes.empty()) return advance_unpushed(servo, servo.torque, input, dt_s, state);
  constexpr double kStep_s = 2e-3;
  const int steps = std::max(1, static_cast<int>(std::ceil(dt_s / kStep_s)));
  const double step_s = dt_s / steps;
  // A push is a load that is constant.
  const auto pushed = [&](const MotorInput& now, const ServoState& at) {
    TorqueModel torque = servo.torque;
    torque.asymmetry_rad_per_s2 -= push_on(servo, now, {at.motor_rad, at.motor_radps});
    return torque;
  };
  for (int k = 0; k < steps && std::isfinite(state.motor_rad); ++k) {
    const MotorInput begins = later(input, k * step_s), halfway = later(begins, 0.5 * step_s);
    ServoState middle = state;
    advance_unpushed(servo, pushed(begins, state), begins, 0.5 * step_s, middle);
    advance_unpushed(servo, pushed(halfway, middle), begins, step_s, state);
  }
}

namespace {

// Moves the drive alone.
void advance_drive(const ServoModel& servo, const MotorInput& input, double dt_s,
                   ServoState& state) {
  if (servo.torque.present)
    advance_servo(servo, input, dt_s, state);
  else
    advance_servo(servo, input.command_rad, dt_s, state);
}

// Over so long at most the way of the drive is a cubic: a motor's angle and rate change smoothly
// (at 30 rad/s the cubic errs by 1e-6 of them); rules of kinematics and play have edges, and a
// straight way over a 200th of the swing errs by less than 1e-4 of it.
double step_behind(const ServoModel& servo) {
  constexpr double kMotor_s = 5e-3, kLeast_s = 1e-4, kOfSwing = 1.0 / 200;
  if (servo.torque.present && servo.backlash_rad == 0) return kMotor_s;
  return std::max(kLeast_s, kOfSwing * servo.elastic.period_s);
}

}  // namespace

void advance_joint(const ServoModel& servo, const MotorInput& input, double dt_s,
                   ServoState& state) {
  if (!servo.elastic.present()) return advance_drive(servo, input, dt_s, state);
  if (!(dt_s > 0)) return;
  const bool motor = servo.torque.present;
  if (!motor) {
    // What jumps to its command does so at once.
    constexpr double kAtOnce_s = 1e-12;
    const double begun_rad = state.load_rad;
    advance_drive(servo, input, kAtOnce_s, state);
    follow_jump(servo.elastic, state.load_rad - begun_rad, state.elastic);
  }
  // A drive that is there stays: one step, however long.
  const bool stands = !motor && state.motor_rad == input.command_rad;
  const int steps =
      stands ? 1 : std::max(1, static_cast<int>(std::ceil(dt_s / step_behind(servo))));
  const double step_s = dt_s / steps;
  const SwingingLoad load(servo.elastic, step_s);
  const bool smooth = motor && servo.backlash_rad == 0;
  for (int k = 0; k < steps; ++k) {
    const DriveState before{state.load_rad, state.motor_radps};
    advance_drive(servo, later(input, step_s * k), step_s, state);
    if (smooth)
      load.follow(before, {state.load_rad, state.motor_radps}, state.elastic);
    else
      load.follow(before.q_rad, state.load_rad, state.elastic);
  }
}

double joint_angle(const ServoModel& servo, const ServoState& state) {
  const double behind = servo.elastic.present() ? state.elastic.q_rad : state.load_rad;
  const double q = behind + servo.ripple.at(behind);
  return servo.sag_rad == 0 ? q : q - servo.sag_rad * maths::cos(q - servo.level_rad);
}

Servo::Servo(ServoModel model, double t_s, double joint_rad)
    : model_(std::move(model)), state_(servo_at_rest(model_, joint_rad)), now_s_(t_s) {
  input_.command_rad = joint_rad;
}

void Servo::begin_moving(double radps, double command_rad, bool enabled, double kp) {
  state_.motor_radps = state_.elastic.w_radps = radps;
  begun_ = true;
  input_.command_rad = command_rad, input_.enabled = enabled, input_.kp = kp;
}

void Servo::nudge(double rad, double radps, double rad_per_s2) {
  state_.motor_rad += rad, state_.load_rad += rad;
  state_.motor_radps += radps;
  model_.torque.asymmetry_rad_per_s2 -= rad_per_s2;  // A load that is constant.
}

// No command acts: the drive stays where it is, and what hangs on it elastically swings on.
void Servo::rest(double dt_s) {
  state_.motor_radps = 0;
  if (begun_ && model_.elastic.present())
    SwingingLoad(model_.elastic, dt_s).follow(state_.load_rad, state_.load_rad, state_.elastic);
}

void Servo::advance_to(double t_s) {
  while (true) {
    const bool more = next_ < queue_.size() && queue_[next_].acts_s < t_s - kSameTime_s;
    const double until = more ? std::max(queue_[next_].acts_s, now_s_) : t_s;
    input_.t_s = now_s_;
    if (begun_ && (model_.torque.present || input_.enabled))
      advance_joint(model_, input_, until - now_s_, state_);
    else
      rest(until - now_s_);
    now_s_ = std::max(now_s_, until);
    if (!more) return;
    begun_ = true;
    input_.enabled = queue_[next_].enabled;
    input_.command_rad = queue_[next_].command_rad;
    input_.kp = queue_[next_].kp;
    ++next_;
  }
}

}  // namespace seam::effects
