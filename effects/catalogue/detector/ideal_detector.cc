#include "effects/effect.h"
#include "effects/stages/detector.h"

namespace seam::effects {

EffectDefinition ideal_detector() {
  return {
      .name = "ideal_detector",
      .stage = Stage::detector,
      .kinds = kLandmarks | kRanges,
      .parameters = {},
      .help = "The detector reports range and bearing as geometry says.",
      .formula = "range and bearing of the landmark in the frame of the camera",
      .signature = "none: it is the base",
      .example = "ideal_detector: {}",
      .base = Base::detector,
      .detector = [](Values, Detection&) {},
      .proof = {{.values = {},
                 .given = {{"range_m", 1.7}, {"bearing_rad", -0.3}},
                 .expected = {{"range_m", 1.7}, {"bearing_rad", -0.3}},
                 .source = "python: 1.7, -0.3"},
                {.values = {},
                 .given = {{"range_m", 0.4}, {"bearing_rad", 1}},
                 .expected = {{"range_m", 0.4}, {"bearing_rad", 1}, {"range_sigma_m", 0}},
                 .source = "python: 0.4, 1, 0"}},
  };
}

}  // namespace seam::effects
