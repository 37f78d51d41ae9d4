#include "effects/effect.h"
#include "effects/stages/detector.h"

namespace seam::effects {

EffectDefinition range_scale() {
  return {
      .name = "range_scale",
      .stage = Stage::detector,
      .kinds = kLandmarks | kRanges,
      .parameters = {{.name = "scale",
                      .min = -0.9,
                      .max = 5,
                      .scale = 0.05,
                      .help = "Relative error of the range."}},
      .help = "Ranges are too long or too short in proportion.",
      .formula = "range * (1 + scale) + offset",
      .signature = "grows with range",
      .example = "range_scale: {scale: 0.05}",
      .detector = [](Values p, Detection& seen) { seen.range_m *= 1 + p[0]; },
  };
}

}  // namespace seam::effects
