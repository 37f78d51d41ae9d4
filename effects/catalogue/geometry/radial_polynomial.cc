#include <cmath>

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
      .term = Term::radial,
      .geometry =
          [](Values p, ImagePoint& point) {
            if (p[0] == 0 && p[1] == 0 && p[2] == 0) return;
            const double r2 = point.x * point.x + point.y * point.y;
            const auto scale = [&](double at2) {
              return 1 + at2 * (p[0] + at2 * (p[1] + at2 * p[2]));
            };
            // Where the radius no longer grows the image folds back: no point is seen there.
            const auto slope = [&](double at2) {
              return 1 + at2 * (3 * p[0] + at2 * (5 * p[1] + at2 * 7 * p[2]));
            };
            if (slope(r2) <= 0) {
              const double fold2 = fold_before(r2, slope);
              point.put_at_edge(std::sqrt(fold2 / r2) * scale(fold2));
              return;
            }
            point.xd *= scale(r2);
            point.yd *= scale(r2);
          },
      .proof =
          {{.values = {-0.12, 0.01, 0.002},
            .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}},
            .expected = {{"u_px", -1.796180736}, {"v_px", 132.4499219968}},
            .source =
                "python: 160 * -0.6 * (1 + p[0] * 0.52 + p[1] * 0.52**2 + p[2] * 0.52**3) + 88.5, "
                "162 * 0.4 * (1 + p[0] * 0.52 + p[1] * 0.52**2 + p[2] * 0.52**3) + 71.5"},
           {.values = {0.2, 0, 0},
            .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
            .expected = {{"u_px", 127.538976}, {"v_px", 45.1486912}},
            .source = "python: 160 * 0.24 * (1 + p[0] * 0.0832) + 88.5, 162 * -0.16 * (1 + p[0] * "
                      "0.0832) + 71.5"}},
  };
}

}  // namespace seam::effects
