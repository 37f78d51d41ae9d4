#include "effects/stages/servo.h"

namespace seam::effects {
namespace {

// Stall and gain over what servos have, with and without a column of gains.
std::vector<std::vector<double>> coarse_look() {
  std::vector<std::vector<double>> values;
  for (const double stall : {30.0, 300.0, 3000.0}) {
    for (const double gain : {1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 3.0, 10.0})
      values.push_back({stall, 10, gain, 0, 1});
  }
  return values;
}

std::vector<Parameter> motor_parameters() {
  return {
      {.name = "stall_rad_per_s2",
       .min = 1e-2,
       .max = 1e6,
       .scale = 1,
       .help = "Angular acceleration at full duty and at rest, rad/s^2: the motor's stall "
               "torque over the inertia of joint and load.",
       .required = true},
      {.name = "back_emf_per_s",
       .min = 0,
       .max = 1e4,
       .scale = 1,
       .help = "Deceleration for each rad/s while the drive is on, 1/s: what the turning "
               "motor takes from its supply."},
      {.name = "gain",
       .min = 1e-7,
       .max = 1e5,
       .scale = 1e-3,
       .help = "Duty (1: the whole supply) for each radian of error and unit of `kp`, the "
               "column of the log; without that column for each radian.",
       .required = true},
      {.name = "damping_s",
       .min = 0,
       .max = 1e3,
       .scale = 1e-3,
       .help = "Duty for each rad/s against the motion, seconds: the controller's own damping. "
               "Where nothing saturates it is back-EMF by another name, so it stays at 0 unless "
               "the data ask for it.",
       .on_demand = true},
      {.name = "max_duty",
       .neutral = 1,
       .min = 1e-3,
       .max = 1,
       .scale = 0.1,
       .help = "Largest duty that the controller asks for.",
       .stated = true}};
}

std::vector<Proof> motor_proof() {
  return {{.values = {200, 10, 0.5, 0, 1},
           .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.15}},
           .expected = {{"joint_rad", 0.610492534557428}},
           .source = "python: sprung(p[0] * p[2], p[1], 1, at_s)"},
          {.values = {300, 8, 0.4, 0.02, 1},
           .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.2}},
           .expected = {{"joint_rad", 0.82463757130636}},
           .source = "python: sprung(p[0] * p[2], p[1] + p[0] * p[3], 1, at_s)"},
          {.values = {300, 20, 5, 0, 0.5},
           .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.1}},
           .expected = {{"joint_rad", 0.42575073121373}},
           .source = "python: p[0] * p[4] / p[1] * (at_s - (1 - math.exp(-p[1] * at_s)) / p[1])"}};
}

}  // namespace

EffectDefinition motor_servo() {
  return {
      .name = "motor_servo",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = motor_parameters(),
      .help =
          "A position controller that drives a motor: the joint has angle and rate, which drive, "
          "load and friction accelerate. Takes the place of ideal_servo and of the kinematic "
          "effects; gravity and friction are effects of their own beside it. Columns `kp`, "
          "`voltage_v` (over its median) and `torque_enable` of a log act where present.",
      .formula =
          "dw/dt = drive - load - friction; drive = stall * duty * V - back_emf * w; duty = "
          "clamp(gain * kp * (command - q) - damping * w, -max_duty, max_duty); torque_enable 0: "
          "drive = 0",
      .signature =
          "error that grows with the load and falls with the gain; overshoot and swinging after "
          "steps; free fall without torque",
      .example = "motor_servo: {stall_rad_per_s2: 300, back_emf_per_s: 20, gain: 4}",
      .has_neutral = false,
      .base = Base::motor,
      .replaces_base = Base::servo,
      .replaces_terms = {Term::kinematic},
      .companions = {"gravity_torque"},
      .starts = {{kJoints, StartSearch::motion, coarse_look()}},
      .advice = {{kJoints,
                  {},
                  "steps and releases (torque_enable 0) at two gains or more: kinematic rules know "
                  "neither gains nor loads"}},
      .servo =
          [](Values p, ServoModel& servo) {
            TorqueModel& motor = servo.torque;
            motor.present = true;
            motor.stall_rad_per_s2 = p[0];
            motor.back_emf_per_s = p[1];
            motor.gain = p[2];
            motor.damping_s = p[3];
            motor.max_duty = p[4];
          },
      .proof = motor_proof(),
  };
}

}  // namespace seam::effects
