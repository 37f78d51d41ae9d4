#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition tangential_distortion() {
  return {
      .name = "tangential_distortion",
      .stage = Stage::geometry,
      .kinds = kPoints | kRanges | kFrames,
      .parameters = {{.name = "p1",
                      .min = -2,
                      .max = 2,
                      .scale = 0.01,
                      .help = "Decentring along columns.",
                      .plausible = {-0.05, 0.05, "calibrations of cameras have 1e-4 to 1e-2"}},
                     {.name = "p2",
                      .min = -2,
                      .max = 2,
                      .scale = 0.01,
                      .help = "Decentring along rows.",
                      .plausible = {-0.05, 0.05, "calibrations of cameras have 1e-4 to 1e-2"}}},
      .help = "The lens is decentred or tilted.",
      .formula = "x + 2 p1 x y + p2 (r2 + 2 x^2), y + p1 (r2 + 2 y^2) + 2 p2 x y",
      .signature = "one-sided, quadratic",
      .example = "tangential_distortion: {p1: 0.004}",
      .term = Term::one_sided,
      .geometry =
          [](Values p, ImagePoint& point) {
            const double x = point.x, y = point.y;
            const double r2 = x * x + y * y;
            point.xd += 2 * p[0] * x * y + p[1] * (r2 + 2 * x * x);
            point.yd += p[0] * (r2 + 2 * y * y) + 2 * p[1] * x * y;
          },
      .proof = {{.values = {0.004, -0.003},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
                 .expected = {{"u_px", 126.755616}, {"v_px", 45.704416}},
                 .source = "python: 160 * tangential(p, 0.24, -0.16)[0] + 88.5, 162 * "
                           "tangential(p, 0.24, -0.16)[1] + 71.5"},
                {.values = {0, 0.02},
                 .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}},
                 .expected = {{"u_px", -3.53199999999998}, {"v_px", 134.7448}},
                 .source = "python: 160 * tangential(p, -0.6, 0.4)[0] + 88.5, 162 * tangential(p, "
                           "-0.6, 0.4)[1] + 71.5"}},
  };
}

}  // namespace seam::effects
