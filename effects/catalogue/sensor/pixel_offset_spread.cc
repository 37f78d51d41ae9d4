#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition pixel_offset_spread() {
  return {
      .name = "pixel_offset_spread",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters =
          {{.name = "sigma_dn", .min = 0, .max = 10000.0, .scale = 1, .help = "One sigma, DN."}},
      .help = "Each pixel has its own fixed offset (DSNU).",
      .formula = "dn + N(0, sigma^2), fixed",
      .signature = "a fixed pattern, also in the dark",
      .example = "pixel_offset_spread: {sigma_dn: 0.8}",
      .spread_only = true,
      .needs = {Need::repeated_pixels},
      .starts = {{kPhotometry, StartSearch::excess}},
      .sensor = [](Values p, SensorChain& chain) { chain.pixel_offset_sigma_dn = p[0]; },
      .start_from_excess =
          [](const SensorExcess& excess) {
            return std::vector<double>{root_at_least(0.02, excess.pattern_dn2)};
          },
      .proof = {{.values = {0.8},
                 .expected = {{"pattern_variance_dn2", 0.64}},
                 .source = "python: p[0]**2"},
                {.values = {3},
                 .given = {{"light", 1}},
                 .expected = {{"pattern_variance_dn2", 9}},
                 .source = "python: p[0]**2"}},
  };
}

}  // namespace seam::effects
