#include "effects/stages/servo.h"

namespace seam::effects {

// Friction of gears that differs between the directions is common in robots' joints (Bona and
// Indri, Friction compensation in robotics: an overview, CDC 2005, have it as two Coulomb levels):
// 5 to 30 % of their mean.
EffectDefinition friction_asymmetry() {
  return {
      .name = "friction_asymmetry",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {{.name = "rad_per_s2",
                      .min = -1e5,
                      .max = 1e5,
                      .scale = 1,
                      .help = "By how much friction is above its mean in motions to larger angles, "
                              "and below it in the others, rad/s^2.",
                      .plausible = {-1e3, 1e3,
                                    "5 to 30 % of dry friction, which takes up to a third of what "
                                    "a servo gives, at most 1e4 rad/s^2"}}},
      .help =
          "Dry friction is unlike in the two directions; what they have in common is "
          "coulomb_friction. A spring with a long way, or a cable that pulls, is the same.",
      .formula = "friction + rad_per_s2 in dw/dt of motor_servo, at whatever rate",
      .signature = "rests beside its command, farther on one side; one direction is slower",
      .example = "friction_asymmetry: {rad_per_s2: 3}",
      .needs_base = Base::motor,
      .starts = {{kJoints, StartSearch::motion, {{0}}}},
      .advice = {{kJoints,
                  {"gravity_torque"},
                  "moves over the whole range: the pull of a load changes with the angle, friction "
                  "does not"},
                 {kJoints,
                  {"encoder_offset"},
                  "two gains: an offset is the same at each, what friction leaves is not"},
                 {kJoints, {}, "slow ramps to and fro over the whole range, at two gains"}},
      .servo = [](Values p, ServoModel& servo) { servo.torque.asymmetry_rad_per_s2 += p[0]; },
      .proof = {{.values = {20},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.2}},
                 .expected = {{"joint_rad", 0.67954050788329}},
                 .source = "python: sprung(100, 10, 1 - p[0] / 100, at_s)"},
                {.values = {-30},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.15}},
                 .expected = {{"joint_rad", 0.793640294924658}},
                 .source = "python: swung(at_s, pull=p[0])",
                 .tolerance = 1e-07}},
  };
}

}  // namespace seam::effects
