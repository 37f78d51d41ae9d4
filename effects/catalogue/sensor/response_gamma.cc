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
                      .help = "Exponent of the response.",
                      .plausible = {0.3, 3.3, "screens and files have 1 / 2.4 to 2.4"}}},
      .help = "The response to light is a power.",
      .formula = "signal = gain * (signal / gain)^gamma",
      .signature = "a curved mean against illumination",
      .example = "response_gamma: {gamma: 0.8}",
      .family = Family::brightness,
      .starts = {{kPhotometry,
                  StartSearch::listed,
                  {{0.35},
                   {0.45},
                   {0.55},
                   {0.65},
                   {0.75},
                   {0.85},
                   {0.93},
                   {0.98},
                   {1.02},
                   {1.08},
                   {1.18},
                   {1.35},
                   {1.6},
                   {2.0},
                   {2.6}}}},
      .sensor = [](Values p, SensorChain& chain) { chain.gamma = p[0]; },
      .proof = {{.values = {0.8},
                 .given = {{"light", 0.5}},
                 .expected = {{"mean_dn", 122.869835499703}},
                 .source = "python: 200 * light**p[0] + 8"},
                {.values = {2.2},
                 .given = {{"light", 0.25}},
                 .expected = {{"mean_dn", 17.47322854069}},
                 .source = "python: 200 * light**p[0] + 8"}},
  };
}

}  // namespace seam::effects
