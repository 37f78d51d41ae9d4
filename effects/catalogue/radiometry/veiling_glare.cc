#include "effects/effect.h"
#include "effects/stages/optics.h"

namespace seam::effects {

EffectDefinition veiling_glare() {
  return {
      .name = "veiling_glare",
      .stage = Stage::radiometry,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "fraction",
                      .min = 0,
                      .max = 1,
                      .scale = 0.05,
                      .help = "Part of the light that is scattered over the whole image.",
                      .plausible = {0, 0.3, "lenses scatter 1 to 10 % of the light (ISO 9358)"}}},
      .help = "Light scattered in the lens lifts the dark parts.",
      .formula = "(1 - fraction) L + fraction mean(L)",
      .signature = "dark parts lifted by the scene's mean",
      .example = "veiling_glare: {fraction: 0.05}",
      .family = Family::brightness,
      .optics = [](Values p, Optics& optics) { optics.glare_fraction = p[0]; },
      .proof = {{.values = {0.05},
                 .given = {{"light", 0.2}, {"mean_light", 0.6}},
                 .expected = {{"seen_light", 0.22}},
                 .source = "python: 0.95 * light + 0.05 * mean_light"},
                {.values = {0.3},
                 .given = {{"light", 1}, {"mean_light", 0.1}},
                 .expected = {{"seen_light", 0.73}},
                 .source = "python: 0.7 * light + 0.3 * mean_light"}},
  };
}

}  // namespace seam::effects
