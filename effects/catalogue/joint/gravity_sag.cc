#include "effects/stages/servo.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

EffectDefinition gravity_sag() {
  return {
      .name = "gravity_sag",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {{.name = "rad",
                      .min = -1,
                      .max = 1,
                      .scale = 0.01,
                      .help =
                          "How far the load hangs where it is level, radians (positive: towards "
                          "smaller angles)."},
                     {.name = "level_rad",
                      .min = -maths::kPi,
                      .max = maths::kPi,
                      .scale = 0.3,
                      .help = "The angle at which the load is level, radians.",
                      .on_demand = true}},
      .help = "A load that is not balanced bends the drive by its torque.",
      .formula = "q - sag * cos(q - level)",
      .signature = "error that depends on the angle, not on the rate",
      .example = "gravity_sag: {rad: 0.02}",
      .servo =
          [](Values p, ServoModel& servo) {
            servo.sag_rad += p[0];
            servo.level_rad += p[1];
          },
  };
}

}  // namespace seam::effects
