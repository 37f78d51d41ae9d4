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
      .term = Term::kinematic,
      .advice = {{kJoints, {}, "large steps and quick reversals"}},
      .servo = [](Values p,
                  ServoModel& servo) { servo.rad_per_s2 = std::min(servo.rad_per_s2, p[0]); },
      .proof = {{.values = {60},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.1}},
                 .expected = {{"joint_rad", 0.3}},
                 .source = "python: p[0] * at_s ** 2 / 2"},
                {.values = {60},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.2}},
                 .expected = {{"joint_rad", 0.898386676965934}},
                 .source = "python: 1 - p[0] * (2 * math.sqrt(1 / p[0]) - at_s) ** 2 / 2"}},
  };
}

}  // namespace seam::effects
