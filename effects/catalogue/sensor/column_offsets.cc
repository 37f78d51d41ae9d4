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
      .sensor = [](Values p, SensorChain& chain) { chain.column_sigma_dn = p[0]; },
  };
}

}  // namespace seam::effects
