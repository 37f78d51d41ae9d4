#include "effects/stages/locomotion.h"

namespace seam::effects {

EffectDefinition walk_lag() {
  return {
      .name = "walk_lag",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {{.name = "tau_s",
                      .min = 0,
                      .max = 10,
                      .scale = 0.1,
                      .help =
                          "Time constant with which the velocity follows its command, seconds."}},
      .help =
          "The body has mass and the gait a period: all three velocities start at rest and "
          "follow their commands with a lag.",
      .formula = "dv/dt = (command - v) / tau",
      .signature = "error after each change of command",
      .example = "walk_lag: {tau_s: 0.2}",
      .locomotion = [](Values p, Locomotion& walk) { walk.tau_s += p[0]; },
  };
}

}  // namespace seam::effects
