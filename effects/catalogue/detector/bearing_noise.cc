#include "effects/effect.h"
#include "effects/stages/detector.h"

namespace seam::effects {

EffectDefinition bearing_noise() {
  return {
      .name = "bearing_noise",
      .stage = Stage::detector,
      .kinds = kLandmarks | kRanges,
      .parameters = {{.name = "sigma_rad",
                      .min = 0,
                      .max = 1,
                      .scale = 0.01,
                      .help = "Standard deviation, radians."}},
      .help = "Spread of a single bearing.",
      .formula = "sigma_rad, each observation",
      .signature = "spread of the bearing",
      .example = "bearing_noise: {sigma_rad: 0.01}",
      .spread_only = true,
      .unknown_cause = true,
      .needs = {Need::bearings},
      .detector = [](Values p, Detection& seen) { seen.bearing_variance += p[0] * p[0]; },
      .proof = {{.values = {0.01},
                 .given = {{"range_m", 2}, {"bearing_rad", 0.5}},
                 .expected = {{"bearing_sigma_rad", 0.01}, {"bearing_rad", 0.5}},
                 .source = "python: p[0], 0.5"},
                {.values = {0.2},
                 .given = {{"range_m", 1}},
                 .expected = {{"bearing_sigma_rad", 0.2}, {"range_sigma_m", 0}},
                 .source = "python: p[0], 0"}},
  };
}

}  // namespace seam::effects
