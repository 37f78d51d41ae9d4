#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition row_noise() {
  return {
      .name = "row_noise",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters =
          {{.name = "sigma_dn", .min = 0, .max = 10000.0, .scale = 1, .help = "One sigma, DN."}},
      .help = "Each row of each frame has an offset of its own.",
      .formula = "dn + N(0, sigma^2), new for each row of each frame",
      .signature = "horizontal stripes that change",
      .example = "row_noise: {sigma_dn: 0.8}",
      .spread_only = true,
      .family = Family::noise,
      .starts = {{kPhotometry, StartSearch::excess}},
      .sensor = [](Values p, SensorChain& chain) { chain.row_sigma_dn = p[0]; },
      .start_from_excess =
          [](const SensorExcess& excess) {
            return std::vector<double>{root_at_least(0.01, excess.row_dn2)};
          },
      .proof = {{.values = {0.8},
                 .expected = {{"row_variance_dn2", 0.64}, {"variance_dn2", 0}},
                 .source = "python: p[0]**2, 0"},
                {.values = {2.5},
                 .given = {{"light", 1}},
                 .expected = {{"row_variance_dn2", 6.25}},
                 .source = "python: p[0]**2"}},
  };
}

}  // namespace seam::effects
