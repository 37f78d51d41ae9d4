#include "effects/effect.h"
#include "effects/stages/optics.h"

namespace seam::effects {

EffectDefinition lens_blur() {
  return {
      .name = "lens_blur",
      .stage = Stage::radiometry,
      .kinds = kFrames | kRanges,
      .parameters = {{.name = "sigma_px",
                      .min = 0,
                      .max = 20,
                      .scale = 0.5,
                      .help = "One sigma of the Gaussian point spread, pixels."},
                     {.name = "window_px",
                      .min = 0,
                      .max = 99,
                      .scale = 5,
                      .help =
                          "Width of the convolution's square, pixels (the founding paper takes 5); "
                          "0: to at least 4 sigma.",
                      .integer = true}},
      .help = "The lens spreads each point of the scene over a Gaussian.",
      .formula = "light * Gaussian(sigma_px), in linear light",
      .signature = "edge width; noise correlation is unaffected",
      .example = "lens_blur: {sigma_px: 1.0}",
      .optics =
          [](Values p, Optics& optics) {
            optics.blur_sigma_px = p[0];
            optics.blur_window_px = static_cast<int>(p[1]);
          },
      .proof = {{.values = {1, 0},
                 .given = {{"edge_px", 0.5}},
                 .expected = {{"edge_light", 0.691462461274013}},
                 .source = "python: (1 + math.erf(edge_px / p[0] / math.sqrt(2))) / 2"},
                {.values = {2, 0},
                 .given = {{"edge_px", -1}},
                 .expected = {{"edge_light", 0.308537538725987}},
                 .source = "python: (1 + math.erf(edge_px / p[0] / math.sqrt(2))) / 2"}},
  };
}

}  // namespace seam::effects
