#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition weak_pixels() {
  return {
      .name = "weak_pixels",
      .stage = Stage::sensor,
      .kinds = kPhotometry,
      .parameters = {{.name = "fraction",
                      .min = 0,
                      .max = 0.2,
                      .scale = 0.001,
                      .help = "Share of the pixels.",
                      .plausible = {0, 0.05, "dust and defects cover less than 1 % of a sensor"}},
                     {.name = "gain",
                      .neutral = 1,
                      .min = 0,
                      .max = 1.5,
                      .scale = 0.1,
                      .help = "Their gain over that of the others."}},
      .help = "Few pixels have a low gain: dust, defects.",
      .formula = "signal * gain for a fixed fraction of the pixels",
      .signature = "isolated dark outliers that stay, in proportion to the light",
      .example = "weak_pixels: {fraction: 0.001, gain: 0.7}",
      .spread_only = true,
      .needs = {Need::repeated_pixels, Need::light},
      .starts = {{kPhotometry, StartSearch::outliers}},
      .sensor = [](Values p,
                   SensorChain& chain) { chain.weak_fraction = p[0], chain.weak_gain = p[1]; },
      .proof = {{.values = {0.001, 0.7},
                 .given = {{"light", 0.5}},
                 .expected = {{"pattern_mean_dn", -0.03}, {"pattern_variance_dn2", 0.8991}},
                 .source = "python: -100 * p[0] * (1 - p[1]), p[0] * (1 - p[0]) * (100 * (1 - "
                           "p[1]))**2"},
                {.values = {0.1, 0.5},
                 .given = {{"light", 1}},
                 .expected = {{"pattern_mean_dn", -10}, {"pattern_variance_dn2", 900}},
                 .source = "python: -200 * p[0] * (1 - p[1]), p[0] * (1 - p[0]) * (200 * (1 - "
                           "p[1]))**2"}},
  };
}

}  // namespace seam::effects
