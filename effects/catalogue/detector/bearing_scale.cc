#include "effects/effect.h"
#include "effects/stages/detector.h"

namespace seam::effects {

EffectDefinition bearing_scale() {
  return {
      .name = "bearing_scale",
      .stage = Stage::detector,
      .kinds = kLandmarks | kRanges,
      .parameters = {{.name = "scale",
                      .min = -0.9,
                      .max = 5,
                      .scale = 0.05,
                      .help = "Relative error of the bearing.",
                      .plausible = {-0.3, 0.5, "a focal length is known within 30 %"}}},
      .help = "Bearings are too large or too small in proportion: a wrong focal length.",
      .formula = "bearing * (1 + scale)",
      .signature = "grows with the bearing",
      .example = "bearing_scale: {scale: -0.03}",
      .needs = {Need::bearings},
      .detector = [](Values p, Detection& seen) { seen.bearing_rad *= 1 + p[0]; },
      .proof = {{.values = {-0.03},
                 .given = {{"range_m", 2}, {"bearing_rad", 0.5}},
                 .expected = {{"range_m", 2}, {"bearing_rad", 0.485}},
                 .source = "python: 2, 0.5 * 0.97"},
                {.values = {0.1},
                 .given = {{"bearing_rad", -0.7}},
                 .expected = {{"bearing_rad", -0.77}},
                 .source = "python: -0.7 * 1.1"}},
  };
}

}  // namespace seam::effects
