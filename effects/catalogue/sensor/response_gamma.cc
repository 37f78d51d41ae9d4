#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition response_gamma() {
  return {
      .name = "response_gamma",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "gamma",
                      .neutral = 1,
                      .min = 0.05,
                      .max = 10,
                      .scale = 0.1,
                      .help = "Exponent of the response."}},
      .help = "The response to light is a power.",
      .formula = "signal = gain * (signal / gain)^gamma",
      .signature = "a curved mean against illumination",
      .example = "response_gamma: {gamma: 0.8}",
      .sensor = [](Values p, SensorChain& chain) { chain.gamma = p[0]; },
  };
}

}  // namespace seam::effects
