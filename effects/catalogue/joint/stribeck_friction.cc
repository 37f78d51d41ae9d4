#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition stribeck_friction() {
  return {
      .name = "stribeck_friction",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {{.name = "rad_per_s2",
                      .min = 0,
                      .max = 1e5,
                      .scale = 1,
                      .help = "Further friction at rest, rad/s^2, which a moving joint loses."},
                     {.name = "rad_per_s",
                      .min = 0,
                      // At more no joint ever loses it: that is Coulomb's.
                      .max = 30,
                      .scale = 0.1,
                      .help = "Rate at which it has fallen to 1/e, rad/s; 0: only at rest."}},
      .help = "Friction that is larger near rest: the joint sticks, then jumps.",
      .formula =
          "friction = rad_per_s2 * exp(-|w| / rad_per_s) * sign(w), in dw/dt of motor_servo; holds "
          "at rest",
      .signature = "slow moves in jumps",
      .example = "stribeck_friction: {rad_per_s2: 5, rad_per_s: 0.3}",
      .needs_base = Base::motor,
      .starts = {{kJoints, StartSearch::motion, {{1, 0.03}, {1, 0.3}, {1, 3}}}},
      .advice = {{kJoints,
                  {},
                  "slow ramps at several rates: the joint sticks and slips below the rate at which "
                  "this friction falls"}},
      .servo =
          [](Values p, ServoModel& servo) {
            servo.torque.stribeck_rad_per_s2 = p[0];
            servo.torque.stribeck_rad_per_s = p[1];
          },
      .proof = {{.values = {20, 0.8},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.2}},
                 .expected = {{"joint_rad", 0.840492911944366}},
                 .source = "python: swung(at_s, stribeck=p[0], slow=p[1])",
                 .tolerance = 1e-07},
                {.values = {101, 0.5},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 1}},
                 .expected = {{"joint_rad", 0}},
                 .source = "python: 0"}},
  };
}

}  // namespace seam::effects
