#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition column_offsets() {
  return {
      .name = "column_offsets",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters =
          {{.name = "sigma_dn", .min = 0, .max = 10000.0, .scale = 1, .help = "One sigma, DN."}},
      .help = "Each column has its own fixed offset.",
      .formula = "dn + N(0, sigma^2), fixed for a column",
      .signature = "vertical stripes that stay",
      .example = "column_offsets: {sigma_dn: 0.8}",
      .spread_only = true,
      .needs = {Need::repeated_pixels},
      .starts = {{kPhotometry, StartSearch::excess}},
      .sensor = [](Values p, SensorChain& chain) { chain.column_sigma_dn = p[0]; },
      .start_from_excess =
          [](const SensorExcess& excess) {
            return std::vector<double>{root_at_least(0.01, excess.column_dn2)};
          },
      .proof = {{.values = {0.8},
                 .expected = {{"pattern_variance_dn2", 0.64}},
                 .source = "python: p[0]**2"},
                {.values = {2},
                 .given = {{"light", 1}},
                 .expected = {{"pattern_variance_dn2", 4}},
                 .source = "python: p[0]**2"}},
  };
}

}  // namespace seam::effects
