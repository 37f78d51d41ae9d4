#include <algorithm>

#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition speed_limit() {
  return {
      .name = "speed_limit",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {{.name = "rad_per_s",
                      .neutral = std::numeric_limits<double>::infinity(),
                      .min = 1e-3,
                      .max = 1e4,
                      .scale = 3,
                      .help = "Largest rate, radians per second.",
                      .fit_reciprocal = true}},
      .help = "The joint turns no faster than this.",
      .formula = "|dq/dt| <= limit",
      .signature = "ramps after steps; nothing while the command is slower than the limit",
      .example = "speed_limit: {rad_per_s: 3.0}",
      .servo = [](Values p,
                  ServoModel& servo) { servo.rad_per_s = std::min(servo.rad_per_s, p[0]); },
  };
}

}  // namespace seam::effects
