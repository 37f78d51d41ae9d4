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
      .sensor = [](Values p, SensorChain& chain) { chain.electrons_per_dn = p[0]; },
  };
}

}  // namespace seam::effects
