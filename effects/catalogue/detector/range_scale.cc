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
                      .help = "Relative error of the range.",
                      .plausible = {-0.5, 1,
                                    "ranges by size or by strength of a signal are within 50 %"}}},
      .help = "Ranges are too long or too short in proportion.",
      .formula = "range * (1 + scale) + offset",
      .signature = "grows with range",
      .example = "range_scale: {scale: 0.05}",
      .needs = {Need::distances},
      .advice = {{kLandmarks,
                  {"range_offset"},
                  "See landmarks from near and from far: a scale grows with the range."},
                 {kRanges,
                  {"focal_length_error"},
                  "Put the ball at the side too: a wrong focal length moves it in the image, a "
                  "scale of the result does not."},
                 {kRanges,
                  {"range_offset"},
                  "Measure from near and from far: a scale grows with the distance."}},
      .detector = [](Values p, Detection& seen) { seen.range_m *= 1 + p[0]; },
      .proof = {{.values = {0.05},
                 .given = {{"range_m", 2}, {"bearing_rad", 0.3}},
                 .expected = {{"range_m", 2.1}, {"bearing_rad", 0.3}},
                 .source = "python: 2 * 1.05, 0.3"},
                {.values = {-0.2},
                 .given = {{"range_m", 0.7}},
                 .expected = {{"range_m", 0.56}},
                 .source = "python: 0.7 * 0.8"}},
  };
}

}  // namespace seam::effects
