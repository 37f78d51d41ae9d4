#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition dark_current() {
  return {
      .name = "dark_current",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "electrons_per_s",
                      .min = 0,
                      .max = 10000000.0,
                      .scale = 500,
                      .help = "Electrons that a pixel collects in a second without light."}},
      .help = "Thermal electrons add to the signal with the exposure time.",
      .formula = "electrons + electrons_per_s * exposure_s",
      .signature = "mean and variance grow with exposure, also in the dark",
      .example = "dark_current: {electrons_per_s: 2000}",
      .sensor = [](Values p, SensorChain& chain) { chain.dark_electrons_per_s = p[0]; },
      .proof = {{.values = {2000},
                 .given = {{"light", 0}, {"exposure_s", 0.01}},
                 .expected = {{"mean_dn", 28}},
                 .source = "python: 8 + p[0] * exposure_s"},
                {.values = {500},
                 .given = {{"light", 0.5}, {"exposure_s", 0.1}},
                 .expected = {{"mean_dn", 158}},
                 .source = "python: 108 + p[0] * exposure_s"}},
  };
}

}  // namespace seam::effects
