#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition radial_polynomial() {
  return {
      .name = "radial_polynomial",
      .stage = Stage::geometry,
      .kinds = kPoints | kRanges | kFrames,
      .parameters =
          {{.name = "k1", .min = -10, .max = 10, .scale = 0.1, .help = "Coefficient of r2."},
           {.name = "k2",
            .min = -50,
            .max = 50,
            .scale = 0.1,
            .help = "Coefficient of r2 squared."},
           {.name = "k3",
            .min = -200,
            .max = 200,
            .scale = 0.1,
            .help = "Coefficient of r2 cubed."}},
      .help = "Radial distortion as a polynomial.",
      .formula = "(x, y) * (1 + k1 r2 + k2 r2^2 + k3 r2^3)",
      .signature = "radial",
      .example = "radial_polynomial: {k1: -0.12, k2: 0.01}",
      .geometry =
          [](Values p, ImagePoint& point) {
            if (p[0] == 0 && p[1] == 0 && p[2] == 0) return;
            const double r2 = point.x * point.x + point.y * point.y;
            // Where the radius no longer grows the image folds back: no point is seen there.
            if (1 + r2 * (3 * p[0] + r2 * (5 * p[1] + r2 * 7 * p[2])) <= 0) point.visible = false;
            const double scale = 1 + r2 * (p[0] + r2 * (p[1] + r2 * p[2]));
            point.xd *= scale;
            point.yd *= scale;
          },
  };
}

}  // namespace seam::effects
