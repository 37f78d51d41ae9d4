#include <cmath>

#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition radial_distortion() {
  return {
      .name = "radial_distortion",
      .stage = Stage::geometry,
      .kinds = kPoints | kRanges | kFrames,
      .parameters = {{.name = "kappa",
                      .min = -2,
                      .max = 2,
                      .scale = 0.1,
                      .help = "Strength; negative is barrel, positive pincushion."}},
      .help = "One-parameter radial distortion, eq. 2 of the founding paper.",
      .formula = "(x, y) * 2 / (1 + sqrt(1 - 4 kappa r2))",
      .signature = "radial, odd in radius",
      .example = "radial_distortion: {kappa: -0.1}",
      .geometry =
          [](Values p, ImagePoint& point) {
            if (p[0] == 0) return;
            // Of the undistorted radius; beyond 4 kappa r2 = 1 the formula has no real value.
            const double root = 1 - 4 * p[0] * (point.x * point.x + point.y * point.y);
            if (root < 0) {
              point.visible = false;
              return;
            }
            const double scale = 2 / (1 + std::sqrt(root));
            point.xd *= scale;
            point.yd *= scale;
          },
  };
}

}  // namespace seam::effects
