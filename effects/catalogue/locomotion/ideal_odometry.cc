#include "effects/stages/locomotion.h"

namespace seam::effects {

EffectDefinition ideal_odometry() {
  return {
      .name = "ideal_odometry",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {},
      .help = "The body moves as commanded: the base to which locomotion effects are added.",
      .formula = "the body moves as commanded",
      .signature = "none: it is the base of walk models",
      .example = "ideal_odometry: {}",
      .has_neutral = false,
      .locomotion = [](Values, Locomotion&) {},
  };
}

}  // namespace seam::effects
