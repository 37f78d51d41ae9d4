#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition coulomb_friction() {
  return {
      .name = "coulomb_friction",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters =
          {{.name = "rad_per_s2",
            .min = 0,
            .max = 1e5,
            .scale = 1,
            .help =
                "Deceleration by dry friction at any rate, rad/s^2; at rest it holds up to this."}},
      .help =
          "Dry friction: constant against the motion; at rest it holds the joint until more pulls.",
      .formula =
          "friction = rad_per_s2 * sign(w), in dw/dt of motor_servo; at rest it holds up to "
          "rad_per_s2",
      .signature =
          "rests beside its command, on the side that it came from; swings end after a while",
      .example = "coulomb_friction: {rad_per_s2: 8}",
      .needs_base = Base::motor,
      .starts = {{kJoints, StartSearch::motion, {{1}, {10}}}},
      .advice =
          {{kJoints,
            {"stribeck_friction"},
            "slow ramps at several rates: Coulomb friction is the same at each, Stribeck's falls "
            "with the rate; starts from rest jump"},
           {kJoints,
            {"load_friction"},
            "the same moves with another load or at other gains: friction by load grows with both"},
           {kJoints,
            {},
            "slow ramps back and forth, and free swings (torque_enable 0) until rest"}},
      .servo = [](Values p, ServoModel& servo) { servo.torque.coulomb_rad_per_s2 = p[0]; },
      .proof = {{.values = {30},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.2}},
                 .expected = {{"joint_rad", 0.594597944397879}},
                 .source = "python: sprung(100, 10, 1 - p[0] / 100, at_s)"},
                {.values = {30},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 2}},
                 .expected = {{"joint_rad", 0.814123474375106}},
                 .source =
                     "python: (1 - p[0] / 100) * (1 + math.exp(-5 * math.pi / math.sqrt(75)))"},
                {.values = {100.5},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 1}},
                 .expected = {{"joint_rad", 0}},
                 .source = "python: 0"}},
  };
}

}  // namespace seam::effects
