#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition pixel_gain_spread() {
  return {
      .name = "pixel_gain_spread",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "sigma",
                      .min = 0,
                      .max = 0.5,
                      .scale = 0.01,
                      .help = "One sigma of the relative gain."}},
      .help = "Each pixel has its own fixed gain (PRNU).",
      .formula = "signal * (1 + N(0, sigma^2)), fixed",
      .signature = "a fixed pattern that grows with the mean",
      .example = "pixel_gain_spread: {sigma: 0.01}",
      .spread_only = true,
      .sensor = [](Values p, SensorChain& chain) { chain.pixel_gain_sigma = p[0]; },
  };
}

}  // namespace seam::effects
