#include <limits>

#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition saturation() {
  return {
      .name = "saturation",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "full_dn",
                      .neutral = std::numeric_limits<double>::infinity(),
                      .min = 0.5,
                      .max = 1000000.0,
                      .scale = 200,
                      .help = "The largest DN.",
                      .resolution = 1}},
      .help = "The read-out clips above a level.",
      .formula = "min(dn, full_dn)",
      .signature = "mean bends and variance falls near the top",
      .example = "saturation: {full_dn: 235}",
      .family = Family::brightness,
      .starts = {{kPhotometry | kFrames, StartSearch::ceiling},
                 {kRanges, StartSearch::listed, {{240}}}},
      .sensor = [](Values p, SensorChain& chain) { chain.full_dn = p[0]; },
      .proof = {{.values = {235},
                 .given = {{"value_dn", 240}},
                 .expected = {{"file_dn", 235}},
                 .source = "python: 235"},
                {.values = {235},
                 .given = {{"value_dn", 100.4}},
                 .expected = {{"file_dn", 100}},
                 .source = "python: 100"}},
  };
}

}  // namespace seam::effects
