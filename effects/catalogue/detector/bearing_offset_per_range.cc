#include "effects/effect.h"
#include "effects/stages/detector.h"

namespace seam::effects {

EffectDefinition bearing_offset_per_range() {
  return {
      .name = "bearing_offset_per_range",
      .stage = Stage::detector,
      .kinds = kLandmarks | kRanges,
      .parameters = {{.name = "rad_per_m",
                      .min = -1,
                      .max = 1,
                      .scale = 5e-3,
                      .help = "Error of the bearing for each metre of range, radians; positive: "
                              "to the left.",
                      .plausible = {-0.1, 0.1,
                                    "a tenth of a radian a metre is half a turn in 30 m"}}},
      .help =
          "Bearings are off by more the farther away the landmark is: what lies beside the "
          "axis near by is sought along a line that is not the axis.",
      .formula = "bearing + rad_per_m * range",
      .signature = "error of the bearing that grows with range",
      .example = "bearing_offset_per_range: {rad_per_m: 0.004}",
      .needs = {Need::bearings},
      .advice = {{kLandmarks, {}, "See the same landmarks from near and from far."}},
      .detector = [](Values p, Detection& seen) { seen.bearing_rad += p[0] * seen.range_m; },
      .proof = {{.values = {0.004},
                 .given = {{"range_m", 2.5}, {"bearing_rad", 0.3}},
                 .expected = {{"bearing_rad", 0.31}, {"range_m", 2.5}},
                 .source = "python: bearing_rad + p[0] * range_m, range_m"},
                {.values = {-0.02},
                 .given = {{"range_m", 1.5}, {"bearing_rad", -0.7}},
                 .expected = {{"bearing_rad", -0.73}},
                 .source = "python: bearing_rad + p[0] * range_m"}},
  };
}

}  // namespace seam::effects
