#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

// EMVA 1288 calls its deviation over pixels DCNU. Data sheets: 0.1 to 1 of the mean dark current,
// which doubles every 6 to 8 kelvin.
EffectDefinition dark_current_spread() {
  return {
      .name = "dark_current_spread",
      .stage = Stage::sensor,
      .kinds = kPhotometry,
      .parameters = {{.name = "sigma_dn_per_s",
                      .min = 0,
                      .max = 1e6,
                      .scale = 10,
                      .help = "One sigma, DN that a second of exposure adds.",
                      .plausible = {0, 1e4,
                                    "data sheets by EMVA 1288: a tenth to the whole of the dark "
                                    "current, 1 to 1000 electrons a second at room temperature"}}},
      .help = "Each pixel has its own dark current (DCNU).",
      .formula = "dn + exposure_s * N(0, sigma^2), the number fixed for a pixel",
      .signature = "a fixed pattern that grows with the exposure time, also in the dark",
      .example = "dark_current_spread: {sigma_dn_per_s: 20}",
      .spread_only = true,
      .needs = {Need::repeated_pixels},
      .starts = {{kPhotometry,
                  StartSearch::listed,
                  {{1}, {3}, {10}, {30}, {100}, {300}, {1000}, {3000}, {10000}}}},
      .advice = {{kPhotometry,
                  {"pixel_offset_spread"},
                  "dark frames at exposure times that differ ten times or more"}},
      .sensor = [](Values p, SensorChain& chain) { chain.dark_sigma_dn_per_s = p[0]; },
      .proof = {{.values = {20},
                 .given = {{"exposure_s", 0.1}},
                 .expected = {{"pattern_variance_dn2", 4}},
                 .source = "python: (p[0] * exposure_s)**2"},
                {.values = {1500},
                 .given = {{"light", 1}, {"exposure_s", 0.02}},
                 .expected = {{"pattern_variance_dn2", 900}},
                 .source = "python: (p[0] * exposure_s)**2"}},
  };
}

}  // namespace seam::effects
