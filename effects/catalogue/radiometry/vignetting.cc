#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition vignetting() {
  return {
      .name = "vignetting",
      .stage = Stage::radiometry,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "a2",
                      .min = -1,
                      .max = 1,
                      .scale = 0.1,
                      .help = "Loss with the square of rho, relative."},
                     {.name = "a4",
                      .min = -1,
                      .max = 1,
                      .scale = 0.1,
                      .help = "Loss with the fourth power of rho, relative."}},
      .help = "The lens gives less light away from the centre (limb darkening).",
      .formula = "gain = 1 - a2 rho^2 - a4 rho^4",
      .signature = "mean falls with radius, in proportion to intensity",
      .example = "vignetting: {a2: 0.28, a4: 0.05}",
      .gain =
          [](Values p, const ImagePoint& point) {
            const double r = rho(point.u, point.v, point.width_px, point.height_px);
            return 1 - p[0] * r * r - p[1] * r * r * r * r;
          },
  };
}

}  // namespace seam::effects
