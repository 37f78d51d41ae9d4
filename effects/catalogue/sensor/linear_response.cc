#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition linear_response() {
  return {
      .name = "linear_response",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "gain_dn",
                      // The light may be in any unit.
                      .min = 1e-12,
                      .max = 1e15,
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
      .base = Base::response,
      .family = Family::brightness,
      .sensor = [](Values p, SensorChain& chain) { chain.gain_dn = p[0], chain.black_dn = p[1]; },
      .proof = {{.values = {220, 16},
                 .given = {{"light", 0.5}},
                 .expected = {{"mean_dn", 126}},
                 .source = "python: p[0] * light + p[1]"},
                {.values = {100, -3},
                 .given = {{"light", 0.25}, {"exposure_ratio", 2}},
                 .expected = {{"mean_dn", 47}},
                 .source = "python: p[0] * light * 2 + p[1]"}},
  };
}

}  // namespace seam::effects
