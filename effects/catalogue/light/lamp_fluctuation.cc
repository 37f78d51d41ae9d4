#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition lamp_fluctuation() {
  return {
      .name = "lamp_fluctuation",
      .stage = Stage::light,
      .kinds = kPhotometry,
      .parameters = {{.name = "sigma",
                      .min = 0,
                      .max = 0.5,
                      .scale = 0.001,
                      .help = "One sigma of a frame's light, relative.",
                      .plausible = {0, 0.2, "lamps keep within 0.1 to 5 %"}}},
      .help = "The light of each frame is off by its own factor.",
      .formula = "light * (1 + N(0, sigma^2)), new for each frame",
      .signature = "means of frames of one level differ in proportion to the light",
      .example = "lamp_fluctuation: {sigma: 0.001}",
      .spread_only = true,
      .family = Family::noise,
      .needs = {Need::light},
      .starts = {{kPhotometry,
                  StartSearch::listed,
                  {{0.0001}, {0.0003}, {0.001}, {0.003}, {0.01}, {0.03}}}},
      .sensor = [](Values p, SensorChain& chain) { chain.lamp_sigma = p[0]; },
      .proof = {{.values = {0.001}, .expected = {{"lamp_sigma", 0.001}}, .source = "python: p[0]"},
                {.values = {0.03}, .expected = {{"lamp_sigma", 0.03}}, .source = "python: p[0]"}},
  };
}

}  // namespace seam::effects
