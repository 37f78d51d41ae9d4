#include <cmath>

#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {
namespace {

constexpr double kGlass = 1.49;  // Index of acrylic glass; other glass up to 1.52.

// From the axis, of a ray that leaves the lens in air with this tangent.
struct Crossing {
  double radius_m = 0;
  double slope = 0;  // Over the tangent.
};

// A ray through air, the pane, and what lies beyond it, by Snell's law.
Crossing crossing(double tangent, double index, double air_m, double pane_m, double beyond_m) {
  const double secant2 = 1 + tangent * tangent, sine2 = tangent * tangent / secant2;
  const double sine = std::sqrt(sine2), by_tangent = 1 / (secant2 * std::sqrt(secant2));
  Crossing at{air_m * tangent, air_m};
  for (const auto& [n, way_m] : {std::pair{kGlass, pane_m}, std::pair{index, beyond_m}}) {
    const double cosine2 = n * n - sine2;
    at.radius_m += way_m * sine / std::sqrt(cosine2);
    at.slope += way_m * n * n / (cosine2 * std::sqrt(cosine2)) * by_tangent;
  }
  return at;
}

void refract(Values p, ImagePoint& point) {
  if (p[0] == 1 && p[2] == 0) return;
  Vec3& p_C = point.p_C;
  const double beyond_m = p_C.z - p[1] - p[2];
  const double r = std::sqrt(p_C.x * p_C.x + p_C.y * p_C.y);
  point.visible = beyond_m > 0;
  if (!(beyond_m > 0) || !(r > 0)) return;
  // The radius grows with the tangent, less and less: Newton's method from the left goes
  // up to the root, in a few steps.
  double tangent = r / p_C.z;
  for (int step = 0; step < 40; ++step) {
    const Crossing at = crossing(tangent, p[0], p[1], p[2], beyond_m);
    const double by = (r - at.radius_m) / at.slope;
    tangent += by;
    // Beyond the slantest ray that leaves the water nothing is seen.
    constexpr double kSlantest = 100;
    if (!(tangent < kSlantest)) {
      point.visible = false;
      return;
    }
    if (std::abs(by) < 1e-13 * (1 + tangent)) break;
  }
  // What follows sees the ray as if it came straight.
  p_C.z = r / tangent;
  point.x = point.xd = p_C.x / p_C.z;
  point.y = point.yd = p_C.y / p_C.z;
}

}  // namespace

// No medium that people look through has an index between 1 and 1.3. A fit that could go there
// would end at none: the way back to a longer focal length without a port goes downhill. Agrawal,
// Ramalingam, Taguchi, Chari, A theory of multi-layer flat refractive geometry, CVPR 2012;
// Treibitz, Schechner, Kunz, Singh, Flat refractive geometry, PAMI 2012. Water: 1.333 (fresh) to
// 1.343 (sea); housings hold a port 5 to 100 mm before the lens, 3 to 20 mm thick.
EffectDefinition flat_port() {
  return {
      .name = "flat_port",
      .stage = Stage::geometry,
      .kinds = kPoints,
      .parameters = {{.name = "index",
                      .neutral = 1,
                      .min = 1.3,
                      .max = 1.7,
                      .scale = 0.05,
                      .help = "Refractive index beyond the port over that of air; water: 1.333.",
                      .plausible = {1.3, 1.53, "water 1.333 to 1.343; oils up to 1.52"}},
                     {.name = "distance_m",
                      .min = 0,
                      .max = 0.3,
                      .scale = 0.01,
                      .help = "From the lens's entrance pupil to the port, metres.",
                      .plausible = {0, 0.15, "housings: 5 to 100 mm before the lens"}},
                     {.name = "thickness_m",
                      .min = 0,
                      .max = 0.1,
                      .scale = 0.005,
                      .help = "Of the port, metres; acrylic glass, index 1.49.",
                      .stated = true,
                      .plausible = {0, 0.05, "ports are 3 to 20 mm thick"}}},
      .help =
          "The camera looks through a flat pane square to its axis, with water or air beyond: an "
          "underwater housing, a window.",
      .formula =
          "r = distance tan a + thickness tan g + (z - distance - thickness) tan w, sin a = 1.49 "
          "sin g = index sin w; the lens sees the angle a",
      .signature = "radial; the image is larger by the index, and unlike at unlike distances",
      .example = "flat_port: {index: 1.333, distance_m: 0.03}",
      .needs = {Need::wide_view},
      .starts = {{kPoints, StartSearch::listed, {{1.333, 0.03, 0}}}},
      .advice =
          {{kPoints,
            {"radial_polynomial", "radial_distortion", "rational_lens", "fisheye"},
            "Calibrate the lens in air and state it: in water alone a port close to the lens "
            "is the same as a lens. Else hold the target near in some views, far in others."},
           {kPoints, {}, "Views at unlike distances, or the lens calibrated in air."},
           {kOutcomes,
            {},
            "a pane has no single viewpoint, and each camera of the simulator has one: state a "
            "lens that does the same at the distance of the scene ('seam measure' makes points "
            "seen through the pane, 'seam fit' finds radial_polynomial in its place)"}},
      .geometry = refract,
      .proof = {{.values = {1.333, 0.03, 0},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
                 .expected = {{"u_px", 140.91878198164}, {"v_px", 36.117322162393}},
                 .source = "python: 160 * through_port(p, x_m, y_m, z_m) * x_m + 88.5, 162 * "
                           "through_port(p, x_m, y_m, z_m) * y_m + 71.5"},
                {.values = {1.34, 0.05, 0.02},
                 .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}},
                 .expected = {{"u_px", -68.1521887872968}, {"v_px", 177.240227431425}},
                 .source = "python: 160 * through_port(p, x_m, y_m, z_m) * x_m + 88.5, 162 * "
                           "through_port(p, x_m, y_m, z_m) * y_m + 71.5"}},
  };
}

}  // namespace seam::effects
