#include <cmath>

#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition rational_lens() {
  const auto coefficient = [](const char* name, double most, const char* help) {
    return Parameter{.name = name, .min = -most, .max = most, .scale = 0.1, .help = help};
  };
  return {
      .name = "rational_lens",
      .stage = Stage::geometry,
      .kinds = kPoints | kRanges | kFrames,
      .parameters = {coefficient("k1", 50, "Coefficient of r2 above."),
                     coefficient("k2", 200, "Coefficient of r2 squared above."),
                     coefficient("k3", 500, "Coefficient of r2 cubed above."),
                     coefficient("k4", 50, "Coefficient of r2 below."),
                     coefficient("k5", 200, "Coefficient of r2 squared below."),
                     coefficient("k6", 500, "Coefficient of r2 cubed below.")},
      .help =
          "Radial distortion as a quotient of polynomials; with `tangential_distortion` and "
          "`thin_prism` it is OpenCV's whole model.",
      .formula = "(x, y) * (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3)",
      .signature = "radial",
      .example = "rational_lens: {k1: 0.4, k2: 0.02, k4: 0.7, k5: 0.1}",
      .term = Term::radial,
      // Where both polynomials are 1 a change of one is the opposite of the other's.
      .starts = {{kPoints,
                  StartSearch::listed,
                  {{-0.1, 0, 0, 0.1, 0, 0}, {0.1, 0, 0, -0.1, 0, 0}}}},
      .geometry =
          [](Values p, ImagePoint& point) {
            const double r2 = point.x * point.x + point.y * point.y;
            const auto above = [&](double at2) {
              return 1 + at2 * (p[0] + at2 * (p[1] + at2 * p[2]));
            };
            const auto below = [&](double at2) {
              return 1 + at2 * (p[3] + at2 * (p[4] + at2 * p[5]));
            };
            // d (r above / below) / dr, times below^2: where the radius no longer grows, or beyond
            // a pole, the image folds back and no point is seen.
            const auto grows = [&](double at2) {
              if (!(below(at2) > 0)) return -1.0;
              const double above_slope = p[0] + at2 * (2 * p[1] + at2 * 3 * p[2]);
              const double below_slope = p[3] + at2 * (2 * p[4] + at2 * 3 * p[5]);
              return above(at2) * below(at2) +
                     2 * at2 * (above_slope * below(at2) - above(at2) * below_slope);
            };
            if (!(grows(r2) > 0)) {
              const double fold2 = fold_before(r2, grows);
              point.put_at_edge(std::sqrt(fold2 / r2) * above(fold2) / below(fold2));
              return;
            }
            point.xd *= above(r2) / below(r2);
            point.yd *= above(r2) / below(r2);
          },
      .proof = {{.values = {0.4, 0.02, 0.001, 0.7, 0.1, 0.003},
                 .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}},
                 .expected = {{"u_px", 4.77462258856768}, {"v_px", 128.014629752717}},
                 .source = "python: 160 * -0.6 * rational(p, 0.52) + 88.5, 162 * 0.4 * rational(p, "
                           "0.52) + 71.5"},
                {.values = {-0.1, 0, 0, 0.2, 0, 0},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
                 .expected = {{"u_px", 125.957223796034}, {"v_px", 46.216373937677}},
                 .source = "python: 160 * 0.24 * rational(p, 0.0832) + 88.5, 162 * -0.16 * "
                           "rational(p, 0.0832) + 71.5"}},
  };
}

}  // namespace seam::effects
