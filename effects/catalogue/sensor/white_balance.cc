#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition white_balance() {
  return {
      .name = "white_balance",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "red_gain",
                      .neutral = 1,
                      .min = 0.01,
                      .max = 100,
                      .scale = 0.1,
                      .help = "Gain of red against green."},
                     {.name = "blue_gain",
                      .neutral = 1,
                      .min = 0.01,
                      .max = 100,
                      .scale = 0.1,
                      .help = "Gain of blue against green."}},
      .help = "The camera scales its colours against each other.",
      .formula = "red * red_gain, blue * blue_gain",
      .signature = "a colour cast in proportion to intensity",
      .example = "white_balance: {red_gain: 1.2, blue_gain: 0.9}",
      .family = Family::brightness,
      .needs = {Need::colour},
      .sensor =
          [](Values p, SensorChain& chain) {
            chain.channel_gain[0] = p[0], chain.channel_gain[2] = p[1];
          },
      .proof = {{.values = {1.2, 0.9},
                 .given = {{"channel", 0}},
                 .expected = {{"mean_dn", 128}},
                 .source = "python: 100 * p[0] + 8"},
                {.values = {1.2, 0.9},
                 .given = {{"channel", 2}},
                 .expected = {{"mean_dn", 98}},
                 .source = "python: 100 * p[1] + 8"},
                {.values = {1.2, 0.9},
                 .given = {{"channel", 1}},
                 .expected = {{"mean_dn", 108}},
                 .source = "python: 108"}},
  };
}

}  // namespace seam::effects
