#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition load_friction() {
  return {
      .name = "load_friction",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters =
          {{.name = "fraction",
            .min = 0,
            .max = 0.95,
            .scale = 0.1,
            .help = "Share of what drive and load leave, |drive - load|, that friction takes.",
            .plausible = {0, 0.8, "worm gears lose up to 70 %, spur gears 5 to 30"}},
           {.name = "carried_fraction",
            .min = 0,
            .max = 0.95,
            .scale = 0.1,
            .help = "Share of what the gears carry between drive and load, |drive + load|, that "
                    "friction takes: where the drive holds a load still, nothing is left to move "
                    "it, yet the gears carry both. Without gravity_torque the same as fraction.",
            .plausible = {0, 0.8, "worm gears lose up to 70 %, spur gears 5 to 30"}}},
      .help = "Friction of gears that grows with the torque that they carry.",
      .formula =
          "friction = (fraction * |drive - load| + carried_fraction * |drive + load|) * sign(w), "
          "in "
          "dw/dt of motor_servo; holds at rest",
      .signature = "slower to speed up and quicker to brake, the more the larger the load",
      .example = "load_friction: {fraction: 0.2}",
      .needs_base = Base::motor,
      .starts = {{kJoints, StartSearch::motion, {{0.1, 0.02}, {0.02, 0.15}}}},
      .advice =
          {{kJoints,
            {"viscous_friction", "stribeck_friction"},
            "the same moves with another load or at other gains: friction by load grows with both"},
           {kJoints, {}, "the same moves with another load or at other gains"}},
      .servo =
          [](Values p, ServoModel& servo) {
            servo.torque.load_fraction = p[0];
            servo.torque.carried_fraction = p[1];
          },
      .proof = {{.values = {0.3, 0},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.12}},
                 .expected = {{"joint_rad", 0.358466698380807}},
                 .source = "python: sprung(100 * (1 - p[0]), 10 * (1 - p[0]), 1, at_s)"},
                {.values = {0.05, 0.15},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.3}},
                 .expected = {{"joint_rad", 1.06730310036058}},
                 .source = "python: swung(at_s, load=p[0] + p[1])",
                 .tolerance = 1e-07}},
  };
}

}  // namespace seam::effects
