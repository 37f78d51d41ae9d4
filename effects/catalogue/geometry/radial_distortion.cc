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
      .term = Term::radial,
      .geometry =
          [](Values p, ImagePoint& point) {
            if (p[0] == 0) return;
            // Of the undistorted radius; beyond 4 kappa r2 = 1 the formula has no real value.
            const double root = 1 - 4 * p[0] * (point.x * point.x + point.y * point.y);
            if (root < 0) {
              point.put_at_edge(2 * std::sqrt(1 / (1 - root)));
              return;
            }
            const double scale = 2 / (1 + std::sqrt(root));
            point.xd *= scale;
            point.yd *= scale;
          },
      .proof =
          {{.values = {-0.1},
            .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
            .expected = {{"u_px", 126.585720215068}, {"v_px", 45.7921388548289}},
            .source =
                "python: 160 * 0.24 * 2 / (1 + math.sqrt(1 + 0.4 * (0.24**2 + 0.16**2))) + 88.5, "
                "162 * -0.16 * 2 / (1 + math.sqrt(1 + 0.4 * (0.24**2 + 0.16**2))) + 71.5"},
           {.values = {0.3},
            .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}},
            .expected = {{"u_px", -30.5189573322352}, {"v_px", 151.837796199259}},
            .source = "python: 160 * -0.6 * 2 / (1 + math.sqrt(1 - 1.2 * 0.52)) + 88.5, 162 * 0.4 "
                      "* 2 / (1 + math.sqrt(1 - 1.2 * 0.52)) + 71.5"}},
  };
}

}  // namespace seam::effects
