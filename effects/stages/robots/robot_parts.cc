#include "effects/stages/robots/robot_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "effects/not_a_number.h"
#include "effects/stages/inertial/inertial.h"
#include "effects/stages/inertial/noise_series.h"
#include "effects/stages/joint_track.h"
#include "effects/stages/servo.h"
#include "effects/stages/walk/locomotion.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"
#include "sim_core/body/joints.h"

namespace seam::effects {
namespace {

// A motor is integrated from tick to tick, counted from where its command began to act, so that
// its angle at any time is the same bits whenever it was asked for before.
constexpr SimDuration kMotorTick = SimDuration::from_ns(5'000'000);

// One command in force: the joint's state where it began to act, from which the motion is closed;
// for a motor, at a later tick, from which it is integrated.
struct Piece {
  SimTime issued;
  SimTime acts;
  double command_rad = 0;
  double speed_radps = 0;
  bool rests = false;  // The first piece: no command acts.
  ServoState state;
  // Of a motor: its controller is given a setpoint that goes to the command at this speed.
  bool is_motor = false;
  // Of an elastic joint, too, the state is had by steps.
  bool is_elastic = false;
  double setpoint_rad = 0;  // Where that was when the command began to act.
  SimTime since;            // The tick of the state.

  // Where the setpoint is, and at which rate it moves.
  std::pair<double, double> setpoint(SimTime time) const {
    const double way = command_rad - setpoint_rad, most = speed_radps * (time - acts).s();
    if (!(std::abs(way) > most)) return {command_rad, 0};
    return {setpoint_rad + std::copysign(most, way), std::copysign(speed_radps, way)};
  }

  void visit(StateVisitor& visitor) {
    visitor.field("issued", issued);
    visitor.field("acts", acts);
    visitor.field("command_rad", command_rad);
    visitor.field("speed_radps", speed_radps);
    visitor.field("rests", rests);
    visitor.field("motor_rad", state.motor_rad);
    visitor.field("motor_radps", state.motor_radps);
    visitor.field("load_rad", state.load_rad);
  }
  void visit_motor(StateVisitor& visitor) {
    is_motor = true;
    visitor.field("setpoint_rad", setpoint_rad);
    visitor.field("since", since);
  }
  void visit_elastic(StateVisitor& visitor) {
    is_elastic = true;
    visitor.field("elastic_rad", state.elastic.q_rad);
    visitor.field("elastic_radps", state.elastic.w_radps);
    if (!is_motor) visitor.field("since", since);
  }
  bool by_ticks() const { return is_motor || is_elastic; }
};

// The servo under a command of this speed.
ServoModel under(const ServoModel& servo, const Piece& piece) {
  ServoModel limited = servo;
  limited.rad_per_s = std::min(limited.rad_per_s, piece.speed_radps);
  return limited;
}

// Moves the piece's state to `time`, no further than the piece's next tick is.
void advance_to(const ServoModel& servo, const Piece& piece, SimTime from, SimTime time,
                ServoState& state) {
  if (!piece.is_motor)
    return advance_joint(under(servo, piece), {.command_rad = piece.command_rad}, (time - from).s(),
                         state);
  const auto [setpoint_rad, radps] = piece.setpoint(from);
  MotorInput input{.command_rad = setpoint_rad, .command_radps = radps, .t_s = from.s()};
  double left_s = (time - from).s();
  if (radps != 0) {
    const double arrives_s = (piece.command_rad - setpoint_rad) / radps;
    if (arrives_s < left_s) {
      advance_joint(servo, input, arrives_s, state);
      left_s -= arrives_s;
      input = {.command_rad = piece.command_rad, .t_s = from.s() + arrives_s};
    }
  }
  advance_joint(servo, input, left_s, state);
}

class ServoActuator final : public JointActuator {
 public:
  ServoActuator(std::string robot, Model model, ServoModel servo, JointRole role,
                double initial_rad)
      : robot_(std::move(robot)), model_(std::move(model)), servo_(std::move(servo)), role_(role) {
    formulas_.swap(servo_.formulas);
    const SimTime always = SimTime::from_ns(std::numeric_limits<int64_t>::min() / 4);
    pieces_.push_back({.issued = always,
                       .acts = always,
                       .command_rad = initial_rad,
                       .rests = true,
                       .state = servo_at_rest(servo_, initial_rad),
                       .is_motor = servo_.torque.present,
                       .is_elastic = servo_.elastic.present(),
                       .setpoint_rad = initial_rad,
                       .since = always});
  }

  void command(SimTime time, double target_rad, double max_speed_radps) override {
    while (pieces_.size() > 1 && pieces_.back().issued >= time) pieces_.pop_back();
    const SimTime acts = time + SimDuration::from_s(servo_.latency_s);
    pieces_.push_back({.issued = time,
                       .acts = acts,
                       .command_rad = target_rad,
                       .speed_radps = max_speed_radps,
                       .state = state_at(acts),
                       .is_motor = servo_.torque.present,
                       .is_elastic = servo_.elastic.present(),
                       .setpoint_rad = piece_at(acts).setpoint(acts).first,
                       .since = acts});
  }

  double angle(SimTime time) const override {
    const Piece& piece = piece_at(time);
    const ServoState state = state_at(time);
    JointSample sample{.q_rad = joint_angle(servo_, state),
                       .rate_rad_per_s = state.motor_radps,
                       .command_rad = piece.command_rad,
                       .t_s = time.s(),
                       .role = role_};
    for (const ModelEffect& formula : formulas_) {
      sample.q_rad = formula.definition->joint_map(formula.values(), sample);
      if (!usable(sample.q_rad))
        fail_with(formula.definition->name, "q", sample.q_rad, robot_at(robot_, time.s()));
    }
    if (!usable(sample.q_rad)) fail_with("servo", "q", sample.q_rad, robot_at(robot_, time.s()));
    return sample.q_rad;
  }

  double encoder(SimTime time) const override {
    double q = state_at(time).motor_rad;
    const auto& all = model_.effects();
    for (auto effect = all.rbegin(); effect != all.rend(); ++effect) {
      if (effect->definition->logged) q = effect->definition->logged(effect->values(), role_, q);
    }
    return q;
  }

  void forget_before(SimTime time) override {
    size_t keep = 0;
    while (keep + 1 < pieces_.size() && pieces_[keep + 1].acts <= time) ++keep;
    pieces_.erase(pieces_.begin(), pieces_.begin() + static_cast<std::ptrdiff_t>(keep));
    Piece& oldest = pieces_.front();
    if (!oldest.by_ticks() || oldest.rests) return;
    while (oldest.since + kMotorTick <= time) {
      advance_to(servo_, oldest, oldest.since, oldest.since + kMotorTick, oldest.state);
      oldest.since = oldest.since + kMotorTick;
    }
  }

  void visit(StateVisitor& visitor) override {
    visitor.list("pieces", pieces_);
    if (servo_.torque.present) {
      for (Piece& piece : pieces_) piece.visit_motor(visitor);
    }
    if (servo_.elastic.present()) {
      for (Piece& piece : pieces_) piece.visit_elastic(visitor);
    }
    if (pieces_.empty()) throw InputError("snapshot: a joint without motion");
  }

 private:
  const Piece& piece_at(SimTime time) const {
    size_t i = pieces_.size() - 1;
    while (i > 0 && pieces_[i].acts > time) --i;
    return pieces_[i];
  }
  ServoState state_at(SimTime time) const {
    const Piece& piece = piece_at(time);
    ServoState state = piece.state;
    if (piece.rests) return state;
    if (piece.by_ticks()) {
      SimTime from = piece.since;
      while (from < time) {
        const SimTime to = std::min(from + kMotorTick, time);
        advance_to(servo_, piece, from, to, state);
        from = to;
      }
      return state;
    }
    advance_servo(under(servo_, piece), piece.command_rad, (time - piece.acts).s(), state);
    return state;
  }

  std::string robot_;
  Model model_;
  ServoModel servo_;  // Without its formulas, so that copies are cheap.
  std::vector<ModelEffect> formulas_;
  JointRole role_;
  std::vector<Piece> pieces_;  // Never empty, ascending.
};

// The constant body velocity whose arc ends where this displacement ends.
BodyVelocity velocity_of_arc(double dx_m, double dy_m, double turn_rad, double dt_s) {
  double along = 1 - turn_rad * turn_rad / 6, across = turn_rad / 2;
  if (std::abs(turn_rad) > 1e-3) {
    const double half = maths::sin(turn_rad / 2);
    along = maths::sin(turn_rad) / turn_rad;
    across = 2 * half * half / turn_rad;
  }
  const double det = along * along + across * across;
  return {(along * dx_m + across * dy_m) / det / dt_s, (along * dy_m - across * dx_m) / det / dt_s,
          turn_rad / dt_s};
}

class ModelLocomotion final : public LocomotionModel {
 public:
  ModelLocomotion(std::string robot, Locomotion walk, const Pose2& from, RandomStream noise)
      : robot_(std::move(robot)),
        walk_(std::move(walk)),
        from_{from.x_m, from.y_m, from.theta_rad},
        noise_(noise.child("walk_noise")) {}

  BodyVelocity velocity(const BodyVelocity& command, SimTime start, SimDuration step) override {
    WalkState state{{.theta_rad = state_.theta_rad}, state_.followed, start.s(), {}, from_};
    const double before_rad = state.theta_rad;
    advance_walk(walk_, command, step.s(), state);
    if (state.broken.formula != nullptr)
      fail_with(state.broken.formula->name, state.broken.output, state.broken.value,
                robot_at(robot_, state.broken.t_s));
    const double c = maths::cos(before_rad), s = maths::sin(before_rad);
    double dx = c * state.x_m + s * state.y_m, dy = -s * state.x_m + c * state.y_m;
    double turn = state.theta_rad - before_rad;
    const double root = std::sqrt(std::max(0.0, state.path_m));
    if (root > 0 && (walk_.xy_sigma > 0 || walk_.theta_sigma > 0)) {
      const auto draw = [&](uint64_t i) {
        return root * normal(noise_, 3 * static_cast<uint64_t>(start.ns()) + i);
      };
      dx += walk_.xy_sigma * draw(0);
      dy += walk_.xy_sigma * draw(1);
      turn += walk_.theta_sigma * draw(2);
    }
    state_ = {{.theta_rad = before_rad + turn}, state.followed};
    if (!walk_.formulas.empty()) go_on(from_.theta_rad + before_rad, dx, dy, state.path_m);
    return velocity_of_arc(dx, dy, turn, step.s());
  }

  void visit(StateVisitor& visitor) override {
    visitor.field("theta_rad", state_.theta_rad);
    if (!walk_.formulas.empty()) {
      visitor.field("x_m", from_.x_m);
      visitor.field("y_m", from_.y_m);
      visitor.field("path_m", from_.path_m);
    }
    state_.followed.visit(visitor);
  }

 private:
  void go_on(double heading_rad, double ahead_m, double left_m, double path_m) {
    const double c = maths::cos(heading_rad), s = maths::sin(heading_rad);
    from_.x_m += c * ahead_m - s * left_m;
    from_.y_m += s * ahead_m + c * left_m;
    from_.path_m += path_m;
  }

  std::string robot_;
  Locomotion walk_;
  Place from_;  // On the field, but for what pushes the robot: kept for formulas alone.
  RandomStream noise_;
  WalkState state_;
};

class ModelInertialReading final : public InertialReading {
 public:
  // Of the gyroscope, or of the accelerometer.
  ModelInertialReading(const Inertial& inertial, bool is_gyroscope, double dt_s,
                       const RandomStream& noise)
      : inertial_(inertial),
        read_(is_gyroscope ? &InertialSample::rate_radps : &InertialSample::force_mps2) {
    for (size_t axis = 0; axis < 3; ++axis)
      axes_.emplace_back(is_gyroscope ? inertial.gyro : inertial.accel, axis, dt_s,
                         noise.child(axis));
  }

  std::vector<double> first_state() const override {
    size_t size = 0;
    for (const NoiseSeries& axis : axes_) size += axis.state_size();
    return std::vector<double>(size, 0);
  }

  Vec3 reading(const BodyMotion& motion, SimTime time, std::vector<double>& state) const override {
    Vec3 seen = measured_by(inertial_, {motion.rate_radps, motion.force_mps2}, kBiasAt_c).*read_;
    std::span<double> left = state;
    for (size_t axis = 0; axis < axes_.size(); ++axis) {
      const size_t size = axes_[axis].state_size();
      double& value = seen[static_cast<int>(axis)];
      value = axes_[axis].reading(value, static_cast<uint64_t>(time.ns()), left.first(size));
      left = left.subspan(size);
    }
    return seen;
  }

 private:
  Inertial inertial_;
  Vec3 InertialSample::*read_;
  std::vector<NoiseSeries> axes_;
};

bool has_joint_effects(const Model& model) {
  return std::any_of(model.effects().begin(), model.effects().end(), [](const ModelEffect& effect) {
    const EffectDefinition& d = *effect.definition;
    return d.servo || d.joint_map || d.logged;
  });
}

}  // namespace

std::unique_ptr<JointActuator> ModelParts::joint(const RobotSpec& robot, int joint,
                                                 double initial_rad, RandomStream noise) const {
  const std::string name = robot.body.joint_name(static_cast<size_t>(joint));
  const auto own = joints_.find({robot.id, name});
  const auto found = models_.find(robot.id);
  const Model* const given = own != joints_.end()     ? &own->second
                             : found != models_.end() ? &found->second
                                                      : nullptr;
  if (!given || !has_joint_effects(*given))
    return RobotPartsFactory::joint(robot, joint, initial_rad, noise);
  const Model& model = *given;
  // A joint's own model means it where it says nothing of tilt or roll, as a set of its log does.
  const JointRole named = joint_role(name);
  const bool is_own = own != joints_.end();
  const JointRole role = is_own && named == JointRole::other ? JointRole::pan : named;
  ServoModel servo = servo_of(model);
  servo.backlash_rad = 0;
  // Gravity turns the head up and down and sideways; the pan's axis is upright and feels none, and
  // what legs feel is the body's weight, which walks are made of.
  const bool feels_gravity = is_own || role == JointRole::tilt || role == JointRole::roll;
  if (!feels_gravity) servo.torque.gravity_rad_per_s2 = 0;
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->play_rad)
      servo.backlash_rad += effect.definition->play_rad(effect.values(), role);
  }
  return std::make_unique<ServoActuator>(robot.id, model, std::move(servo), role, initial_rad);
}

std::unique_ptr<LocomotionModel> ModelParts::locomotion(const RobotSpec& robot,
                                                        RandomStream noise) const {
  const auto found = models_.find(robot.id);
  const bool walks = found != models_.end() &&
                     std::any_of(found->second.effects().begin(), found->second.effects().end(),
                                 [](const ModelEffect& e) {
                                   return e.definition->locomotion || e.definition->velocity_map;
                                 });
  if (!walks) return RobotPartsFactory::locomotion(robot, noise);
  return std::make_unique<ModelLocomotion>(robot.id, locomotion_of(found->second), robot.pose,
                                           noise);
}

std::shared_ptr<const InertialReading> ModelParts::accelerometer(const RobotSpec& robot,
                                                                 RandomStream noise) const {
  return inertial_sensor(robot, false, robot.sensors.accelerometer.period, noise);
}

std::shared_ptr<const InertialReading> ModelParts::gyroscope(const RobotSpec& robot,
                                                             RandomStream noise) const {
  if (!robot.sensors.gyroscope) return nullptr;
  return inertial_sensor(robot, true, robot.sensors.gyroscope->period, noise);
}

std::shared_ptr<const InertialReading> ModelParts::inertial_sensor(
    const RobotSpec& robot, bool is_gyroscope, SimDuration period,
    const RandomStream& noise) const {
  const auto found = models_.find(robot.id);
  if (found == models_.end()) return nullptr;
  const auto& effects = found->second.effects();
  const bool acts = std::any_of(effects.begin(), effects.end(), [](const ModelEffect& effect) {
    return effect.definition->stage == kInertial;
  });
  if (!acts) return nullptr;
  return std::make_shared<ModelInertialReading>(inertial_of(found->second), is_gyroscope,
                                                period.s(), noise);
}

}  // namespace seam::effects
