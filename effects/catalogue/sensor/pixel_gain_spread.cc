#include <algorithm>

#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition pixel_gain_spread() {
  return {
      .name = "pixel_gain_spread",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "sigma",
                      .min = 0,
                      .max = 0.5,
                      .scale = 0.01,
                      .help = "One sigma of the relative gain.",
                      .plausible = {0, 0.1, "data sheets by EMVA 1288: 0.3 to 3 %"}}},
      .help = "Each pixel has its own fixed gain (PRNU).",
      .formula = "signal * (1 + N(0, sigma^2)), fixed",
      .signature = "a fixed pattern that grows with the mean",
      .example = "pixel_gain_spread: {sigma: 0.01}",
      .spread_only = true,
      .needs = {Need::repeated_pixels},
      .starts = {{kPhotometry, StartSearch::excess}},
      .sensor = [](Values p, SensorChain& chain) { chain.pixel_gain_sigma = p[0]; },
      .start_from_excess =
          [](const SensorExcess& excess) {
            return std::vector<double>{std::min(0.3, root_at_least(1e-4, excess.pattern_of_gain))};
          },
      .proof = {{.values = {0.01},
                 .given = {{"light", 0.5}},
                 .expected = {{"pattern_variance_dn2", 1}},
                 .source = "python: (p[0] * 100)**2"},
                {.values = {0.03},
                 .given = {{"light", 1}},
                 .expected = {{"pattern_variance_dn2", 36}},
                 .source = "python: (p[0] * 200)**2"}},
  };
}

}  // namespace seam::effects
