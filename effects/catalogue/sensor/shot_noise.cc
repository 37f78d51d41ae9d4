#include <algorithm>
#include <limits>

#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition shot_noise() {
  return {
      .name = "shot_noise",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "electrons_per_dn",
                      .neutral = std::numeric_limits<double>::infinity(),
                      .min = 0.001,
                      .max = 1000000000.0,
                      .scale = 50,
                      .help = "Electrons that make one DN at gain 1."}},
      .help = "Light comes in photons: counts are Poisson in electrons.",
      .formula = "electrons = Poisson(signal * electrons_per_dn)",
      .signature = "variance in proportion to the mean above black",
      .example = "shot_noise: {electrons_per_dn: 50}",
      .spread_only = true,
      .family = Family::noise,
      .starts = {{kPhotometry, StartSearch::excess}},
      .sensor = [](Values p, SensorChain& chain) { chain.electrons_per_dn = p[0]; },
      .start_from_excess =
          [](const SensorExcess& excess) {
            return std::vector<double>{1 / std::clamp(excess.per_signal_dn, 1e-6, 100.0)};
          },
      .proof = {{.values = {50},
                 .given = {{"light", 0.5}},
                 .expected = {{"mean_dn", 108}, {"variance_dn2", 2}},
                 .source = "python: 108, 100 / p[0]"},
                {.values = {8},
                 .given = {{"light", 1}},
                 .expected = {{"mean_dn", 208}, {"variance_dn2", 25}},
                 .source = "python: 208, 200 / p[0]"}},
  };
}

}  // namespace seam::effects
