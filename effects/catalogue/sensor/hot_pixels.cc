#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition hot_pixels() {
  return {
      .name = "hot_pixels",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "fraction",
                      .min = 0,
                      .max = 0.2,
                      .scale = 0.001,
                      .help = "Share of the pixels.",
                      .plausible = {0, 0.05, "data sheets of sensors: less than 1 %"}},
                     {.name = "level_dn",
                      .min = -60000.0,
                      .max = 60000.0,
                      .scale = 30,
                      .help = "Their offset, DN."}},
      .help = "Few pixels have a large fixed offset.",
      .formula = "dn + level for a fixed fraction of the pixels",
      .signature = "isolated outliers that stay",
      .example = "hot_pixels: {fraction: 0.001, level_dn: 40}",
      .spread_only = true,
      .needs = {Need::repeated_pixels},
      .starts = {{kPhotometry, StartSearch::outliers}},
      .sensor = [](Values p,
                   SensorChain& chain) { chain.hot_fraction = p[0], chain.hot_level_dn = p[1]; },
      .proof = {{.values = {0.001, 40},
                 .expected = {{"pattern_mean_dn", 0.04}, {"pattern_variance_dn2", 1.5984}},
                 .source = "python: p[0] * p[1], p[0] * (1 - p[0]) * p[1]**2"},
                {.values = {0.1, -20},
                 .expected = {{"pattern_mean_dn", -2}, {"pattern_variance_dn2", 36}},
                 .source = "python: p[0] * p[1], p[0] * (1 - p[0]) * p[1]**2"}},
  };
}

}  // namespace seam::effects
