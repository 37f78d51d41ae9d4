#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition quantisation() {
  return {
      .name = "quantisation",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "bits",
                      .neutral = 0,
                      .min = 1,
                      .max = 16,
                      .scale = 1,
                      .help = "Bits of the converter.",
                      .integer = true}},
      .help = "The converter has fewer bits than the file.",
      .formula = "rounded to multiples of 2^(file bits - bits)",
      .signature = "steps, a floor of the variance",
      .example = "quantisation: {bits: 6}",
      .starts = {{kPhotometry | kRanges | kFrames, StartSearch::converter_bits}},
      .sensor = [](Values p, SensorChain& chain) { chain.bits = static_cast<int>(p[0]); },
      .proof = {{.values = {6},
                 .given = {{"value_dn", 101}},
                 .expected = {{"file_dn", 100}},
                 .source = "python: round(101 / 4) * 4"},
                {.values = {5},
                 .given = {{"value_dn", 117}},
                 .expected = {{"file_dn", 120}},
                 .source = "python: round(117 / 8) * 8"}},
  };
}

}  // namespace seam::effects
