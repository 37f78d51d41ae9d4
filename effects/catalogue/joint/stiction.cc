#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition stiction() {
  return {
      .name = "stiction",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {{.name = "dead_band_rad",
                      .min = 0,
                      .max = 1,
                      .scale = 0.01,
                      .help =
                          "The joint rests while it is nearer to its command than this, radians."}},
      .help = "Static friction: a command that is too near does not move the joint.",
      .formula = "no motion while |command - q| < band",
      .signature = "steady error after small moves",
      .example = "stiction: {dead_band_rad: 0.01}",
      .servo = [](Values p, ServoModel& servo) { servo.dead_band_rad += p[0]; },
  };
}

}  // namespace seam::effects
