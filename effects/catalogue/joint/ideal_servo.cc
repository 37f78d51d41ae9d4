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
      .servo = [](Values, ServoModel&) {},
  };
}

}  // namespace seam::effects
