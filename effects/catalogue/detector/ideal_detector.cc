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
      .detector = [](Values, Detection&) {},
  };
}

}  // namespace seam::effects
