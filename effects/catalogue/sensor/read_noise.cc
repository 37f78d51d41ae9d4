#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition read_noise() {
  return {
      .name = "read_noise",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters =
          {{.name = "sigma_dn", .min = 0, .max = 10000.0, .scale = 1, .help = "One sigma, DN."}},
      .help = "Gaussian noise of the read-out, new for each pixel and frame.",
      .formula = "dn + N(0, sigma^2)",
      .signature = "variance in the dark",
      .example = "read_noise: {sigma_dn: 1.4}",
      .spread_only = true,
      .family = Family::noise,
      .starts = {{kPhotometry, StartSearch::excess}},
      .sensor = [](Values p, SensorChain& chain) { chain.read_sigma_dn = p[0]; },
      .start_from_excess =
          [](const SensorExcess& excess) {
            return std::vector<double>{root_at_least(0.05, excess.temporal_dn2)};
          },
      .proof = {{.values = {1.4},
                 .expected = {{"variance_dn2", 1.96}, {"mean_dn", 108}},
                 .source = "python: p[0]**2, 108"},
                {.values = {3},
                 .given = {{"light", 0}},
                 .expected = {{"variance_dn2", 9}, {"mean_dn", 8}},
                 .source = "python: p[0]**2, 8"}},
  };
}

}  // namespace seam::effects
