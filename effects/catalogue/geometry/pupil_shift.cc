#include <cmath>

#include "effects/effect.h"
#include "effects/stages/geometry.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

EffectDefinition pupil_shift() {
  return {
      .name = "pupil_shift",
      .stage = Stage::geometry,
      .kinds = kPoints,
      .parameters = {{.name = "forward_m",
                      .min = -0.01,
                      .max = 0.01,
                      .scale = 1e-3,
                      .help = "How fast the point through which rays enter moves towards the scene "
                              "as they slant, m: a few millimetres in lenses of cameras.",
                      .plausible = {-0.006, 0.006, "a few millimetres in lenses of cameras"}}},
      .help =
          "Rays of a wide lens do not meet in one point: slanting ones enter further forward, "
          "which shows where the scene is near (Gennery 2006).",
      .formula = "z - forward_m (theta / sin theta - 1), theta the point's angle from the axis",
      .signature = "radial, unlike at unlike distances",
      .example = "pupil_shift: {forward_m: 0.003}",
      .needs = {Need::several_views},
      .advice = {{kPoints,
                  {},
                  "A pupil that moves looks like the lens where the target is always as far away: "
                  "hold it near in some views and far in others."}},
      .geometry =
          [](Values p, ImagePoint& point) {
            Vec3& p_C = point.p_C;
            const double r = std::sqrt(p_C.x * p_C.x + p_C.y * p_C.y);
            const double distance = std::sqrt(r * r + p_C.z * p_C.z);
            // On the axis the quotient's limit is 1.
            constexpr double kOnAxis = 1e-7;
            if (!(r > kOnAxis * distance)) return;
            p_C.z -= p[0] * (maths::quick_atan2(r, p_C.z) * distance / r - 1);
            point.visible = p_C.z > 0;
            point.x = point.xd = p_C.x / p_C.z;
            point.y = point.yd = p_C.y / p_C.z;
          },
      .proof = {{.values = {0.003},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
                 .expected = {{"u_px", 126.901222578518}, {"v_px", 45.5791747595003}},
                 .source = "python: 160 * x_m / slid(p, x_m, y_m, z_m) + 88.5, 162 * y_m / slid(p, "
                           "x_m, y_m, z_m) + 71.5"},
                {.values = {-0.008},
                 .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}},
                 .expected = {{"u_px", -7.43027306101577}, {"v_px", 136.252934316186}},
                 .source = "python: 160 * x_m / slid(p, x_m, y_m, z_m) + 88.5, 162 * y_m / slid(p, "
                           "x_m, y_m, z_m) + 71.5"}},
  };
}

}  // namespace seam::effects
