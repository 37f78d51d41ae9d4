#include "effects/effect.h"
#include "effects/stages/detector.h"

namespace seam::effects {

EffectDefinition range_noise() {
  return {
      .name = "range_noise",
      .stage = Stage::detector,
      .kinds = kLandmarks | kRanges,
      .parameters = {{.name = "sigma_m",
                      .min = 0,
                      .max = 5,
                      .scale = 0.02,
                      .help = "Part that does not depend on range, metres."},
                     {.name = "sigma_per_m",
                      .min = 0,
                      .max = 2,
                      .scale = 0.02,
                      .help = "Part in proportion to range."}},
      .help = "Spread of a single range.",
      .formula = "sigma = sqrt(sigma_m^2 + (sigma_per_m * range)^2)",
      .signature = "spread of the range",
      .example = "range_noise: {sigma_per_m: 0.02}",
      .spread_only = true,
      .unknown_cause = true,
      .needs = {Need::distances},
      .detector =
          [](Values p, Detection& seen) {
            seen.range_variance += p[0] * p[0] + p[1] * p[1] * seen.range_m * seen.range_m;
          },
      .proof = {{.values = {0.02, 0.03},
                 .given = {{"range_m", 2}},
                 .expected = {{"range_sigma_m", 0.0632455532033676}, {"range_m", 2}},
                 .source = "python: math.hypot(p[0], p[1] * range_m), 2"},
                {.values = {0, 0.1},
                 .given = {{"range_m", 0.5}},
                 .expected = {{"range_sigma_m", 0.05}},
                 .source = "python: p[1] * range_m"}},
  };
}

}  // namespace seam::effects
