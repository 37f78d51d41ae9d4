#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition tangential_distortion() {
  return {
      .name = "tangential_distortion",
      .stage = Stage::geometry,
      .kinds = kPoints | kRanges | kFrames,
      .parameters =
          {{.name = "p1", .min = -2, .max = 2, .scale = 0.01, .help = "Decentring along columns."},
           {.name = "p2", .min = -2, .max = 2, .scale = 0.01, .help = "Decentring along rows."}},
      .help = "The lens is decentred or tilted.",
      .formula = "x + 2 p1 x y + p2 (r2 + 2 x^2), y + p1 (r2 + 2 y^2) + 2 p2 x y",
      .signature = "one-sided, quadratic",
      .example = "tangential_distortion: {p1: 0.004}",
      .geometry =
          [](Values p, ImagePoint& point) {
            const double x = point.x, y = point.y;
            const double r2 = x * x + y * y;
            point.xd += 2 * p[0] * x * y + p[1] * (r2 + 2 * x * x);
            point.yd += p[0] * (r2 + 2 * y * y) + 2 * p[1] * x * y;
          },
  };
}

}  // namespace seam::effects
