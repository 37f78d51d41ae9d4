#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition thin_prism() {
  const auto coefficient = [](const char* name, const char* help) {
    return Parameter{.name = name, .min = -2, .max = 2, .scale = 0.01, .help = help};
  };
  return {
      .name = "thin_prism",
      .stage = Stage::geometry,
      .kinds = kPoints | kRanges | kFrames,
      .parameters = {coefficient("s1", "Along rows, coefficient of r2."),
                     coefficient("s2", "Along rows, coefficient of r2 squared."),
                     coefficient("s3", "Along columns, coefficient of r2."),
                     coefficient("s4", "Along columns, coefficient of r2 squared.")},
      .help = "A lens or the sensor's cover acts as a thin prism (OpenCV's s1 to s4).",
      .formula = "x + s1 r2 + s2 r2^2, y + s3 r2 + s4 r2^2",
      .signature = "one-sided, grows with the square of the radius",
      .example = "thin_prism: {s1: 0.001}",
      .term = Term::one_sided,
      .geometry =
          [](Values p, ImagePoint& point) {
            const double r2 = point.x * point.x + point.y * point.y;
            point.xd += r2 * (p[0] + r2 * p[1]);
            point.yd += r2 * (p[2] + r2 * p[3]);
          },
      .proof = {{.values = {0.002, -0.001, 0.003, 0.004},
                 .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}},
                 .expected = {{"u_px", -7.37686399999998}, {"v_px", 136.7279392}},
                 .source = "python: 160 * (-0.6 + p[0] * 0.52 + p[1] * 0.52**2) + 88.5, 162 * (0.4 "
                           "+ p[2] * 0.52 + p[3] * 0.52**2) + 71.5"},
                {.values = {0, 0.01, -0.02, 0},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
                 .expected = {{"u_px", 126.911075584}, {"v_px", 45.310432}},
                 .source = "python: 160 * (0.24 + p[1] * 0.0832**2) + 88.5, 162 * (-0.16 + p[2] * "
                           "0.0832) + 71.5"}},
  };
}

}  // namespace seam::effects
