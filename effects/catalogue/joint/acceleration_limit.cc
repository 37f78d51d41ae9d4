#include <algorithm>

#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition acceleration_limit() {
  return {
      .name = "acceleration_limit",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {{.name = "rad_per_s2",
                      .neutral = std::numeric_limits<double>::infinity(),
                      .min = 1e-2,
                      .max = 1e7,
                      .scale = 100,
                      .help = "Largest acceleration, radians per second squared.",
                      .fit_reciprocal = true}},
      .help =
          "The joint speeds up and brakes no harder than this, and brakes in time to stop at its "
          "target. A target that comes nearer too late is overshot.",
      .formula = "|d2q/dt2| <= limit, braking in time to stop at the target",
      .signature = "rounded ramps after steps; overshoot when the command turns back",
      .example = "acceleration_limit: {rad_per_s2: 60}",
      .servo = [](Values p,
                  ServoModel& servo) { servo.rad_per_s2 = std::min(servo.rad_per_s2, p[0]); },
  };
}

}  // namespace seam::effects
