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
      .sensor = [](Values p, SensorChain& chain) { chain.read_sigma_dn = p[0]; },
  };
}

}  // namespace seam::effects
