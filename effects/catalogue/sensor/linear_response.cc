#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition linear_response() {
  return {
      .name = "linear_response",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "gain_dn",
                      .min = 0.001,
                      .max = 1000000.0,
                      .scale = 100,
                      .help = "DN for illumination 1 at the first exposure.",
                      .required = true},
                     {.name = "black_dn",
                      .min = -10000.0,
                      .max = 60000.0,
                      .scale = 5,
                      .help = "DN in the dark."}},
      .help = "The pixel counts in proportion to light, above a black level.",
      .formula = "dn = gain * illumination + black",
      .signature = "mean against illumination: slope and level",
      .example = "linear_response: {gain_dn: 220, black_dn: 8}",
      .sensor = [](Values p, SensorChain& chain) { chain.gain_dn = p[0], chain.black_dn = p[1]; },
  };
}

}  // namespace seam::effects
