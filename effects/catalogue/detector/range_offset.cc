#include "effects/effect.h"
#include "effects/stages/detector.h"

namespace seam::effects {

EffectDefinition range_offset() {
  return {
      .name = "range_offset",
      .stage = Stage::detector,
      .kinds = kLandmarks | kRanges,
      .parameters = {{.name = "offset_m",
                      .min = -5,
                      .max = 5,
                      .scale = 0.05,
                      .help = "Reported minus true range, metres."}},
      .help = "Ranges are too long or too short by a constant.",
      .formula = "range * (1 + scale) + offset",
      .signature = "constant",
      .example = "range_offset: {offset_m: 0.03}",
      .needs = {Need::distances},
      .detector = [](Values p, Detection& seen) { seen.range_m += p[0]; },
      .proof = {{.values = {0.03},
                 .given = {{"range_m", 2}},
                 .expected = {{"range_m", 2.03}},
                 .source = "python: 2.03"},
                {.values = {-0.1},
                 .given = {{"range_m", 0.7}, {"bearing_rad", 0.2}},
                 .expected = {{"range_m", 0.6}, {"bearing_rad", 0.2}},
                 .source = "python: 0.7 - 0.1, 0.2"}},
  };
}

}  // namespace seam::effects
