#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition ideal_servo() {
  return {
      .name = "ideal_servo",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {},
      .help = "The joint is at its command at once: the base to which servo effects are added.",
      .formula = "angle = command",
      .signature = "none: it is the base of servo models",
      .example = "ideal_servo: {}",
      .has_neutral = false,
      .base = Base::servo,
      .servo = [](Values, ServoModel&) {},
      .proof = {{.values = {},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.01}},
                 .expected = {{"joint_rad", 1}},
                 .source = "python: 1"},
                {.values = {},
                 .given = {{"command_s", 0},
                           {"command_rad", 0.5},
                           {"command_s", 0.1},
                           {"command_rad", 0.2},
                           {"at_s", 0.2}},
                 .expected = {{"joint_rad", 0.2}},
                 .source = "python: 0.2"}},
  };
}

}  // namespace seam::effects
