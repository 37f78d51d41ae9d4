#include "effects/stages/locomotion.h"

namespace seam::effects {

EffectDefinition heading_drift() {
  return {
      .name = "heading_drift",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {{.name = "rad_per_m",
                      .min = -5,
                      .max = 5,
                      .scale = 0.05,
                      .help = "Turn for each metre of path, radians; positive: to the left."}},
      .help = "Legs that push unevenly turn the body while it walks.",
      .formula = "omega + rad_per_m * sqrt(vx^2 + vy^2)",
      .signature = "heading error with distance",
      .example = "heading_drift: {rad_per_m: 0.05}",
      .locomotion = [](Values p, Locomotion& walk) { walk.heading_rad_per_m += p[0]; },
  };
}

}  // namespace seam::effects
