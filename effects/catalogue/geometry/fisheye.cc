#include <cmath>

#include "effects/effect.h"
#include "effects/stages/geometry.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

EffectDefinition fisheye() {
  return {
      .name = "fisheye",
      .stage = Stage::geometry,
      .kinds = kPoints | kRanges | kFrames,
      .parameters =
          {{.name = "k1", .min = -5, .max = 5, .scale = 0.05, .help = "Coefficient of theta^2."},
           {.name = "k2", .min = -5, .max = 5, .scale = 0.05, .help = "Coefficient of theta^4."},
           {.name = "k3", .min = -5, .max = 5, .scale = 0.05, .help = "Coefficient of theta^6."},
           {.name = "k4", .min = -5, .max = 5, .scale = 0.05, .help = "Coefficient of theta^8."}},
      .help =
          "The Kannala-Brandt lens; replaces the perspective projection and excludes other radial "
          "effects.",
      .formula = "r_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)",
      .signature = "large radial residual that changes sign",
      .example = "fisheye: {k1: -0.02, k2: 0.001}",
      .has_neutral = false,
      .replaces_base = Base::projection,
      .term = Term::angular,
      .replaces_terms = {Term::radial},
      .needs = {Need::wide_view},
      .starts = {{kPoints, StartSearch::listed, {{0, 0, 0, 0}}}},
      .geometry =
          [](Values p, ImagePoint& point) {
            const Vec3& ray = point.p_C;
            const double r = std::sqrt(ray.x * ray.x + ray.y * ray.y);
            const double theta = maths::quick_atan2(r, ray.z);
            const auto radius = [&](double angle) {
              const double t2 = angle * angle;
              return angle * (1 + t2 * (p[0] + t2 * (p[1] + t2 * (p[2] + t2 * p[3]))));
            };
            // Where the radius no longer grows with the angle the image folds back: nothing is seen
            // there.
            const auto slope = [&](double angle) {
              const double t2 = angle * angle;
              return 1 + t2 * (3 * p[0] + t2 * (5 * p[1] + t2 * (7 * p[2] + t2 * 9 * p[3])));
            };
            point.visible = slope(theta) > 0;
            point.at_edge = !point.visible;
            const double r_d = radius(point.visible ? theta : fold_before(theta, slope));
            const double along_x = r > 0 ? ray.x / r : 0;
            const double along_y = r > 0 ? ray.y / r : 0;
            point.x = point.xd = r_d * along_x;
            point.y = point.yd = r_d * along_y;
          },
      .proof = {{.values = {-0.02, 0.001, 0, 0},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
                 .expected = {{"u_px", 125.826502777176}, {"v_px", 46.3046106254062}},
                 .source = "python: 160 * fisheye(p, x_m, y_m, z_m) * x_m + 88.5, 162 * fisheye(p, "
                           "x_m, y_m, z_m) * y_m + 71.5"},
                {.values = {0.1, -0.02, 0.003, -0.0005},
                 .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}},
                 .expected = {{"u_px", 2.32092940350296}, {"v_px", 129.670872652635}},
                 .source = "python: 160 * fisheye(p, x_m, y_m, z_m) * x_m + 88.5, 162 * fisheye(p, "
                           "x_m, y_m, z_m) * y_m + 71.5"}},
  };
}

}  // namespace seam::effects
