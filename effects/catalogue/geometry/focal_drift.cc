#include <cmath>
#include <limits>

#include "effects/effect.h"
#include "effects/stages/geometry.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

// Lens, spacers and housing expand by 1e-5 (glass, metal) to 1e-4 (plastic) a kelvin: 1e-4 to 3e-3
// of the focal length for 10 to 30 K, within half an hour (smartphones in 25 minutes: Elias,
// Eltner, Liebold, Maas, Sensors 20, 643, 2020; reflex cameras: Smith and Cope, ISPRS Archives
// 38-5, 2010). Plausible: up to 3e-6 a second; a lens that creeps or is focused by a servo drifts
// faster, a zoom that runs by up to a half a second.
EffectDefinition focal_drift() {
  return {
      .name = "focal_drift",
      .stage = Stage::geometry,
      .kinds = kPoints | kRanges | kFrames,
      .parameters = {{.name = "per_s",
                      .min = -0.5,
                      .max = 0.5,
                      .scale = 1e-4,
                      .help = "Growth of the focal length in a second, as a share of it, at the "
                              "set's first time.",
                      .plausible = {-0.2, 0.2, "a zoom that is turned: a fifth in a second"}},
                     {.name = "tau_s",
                      .neutral = std::numeric_limits<double>::infinity(),
                      .min = 1e-2,
                      .max = 1e6,
                      .scale = 600,
                      .help = "The drift dies out in this time constant, seconds.",
                      .fit_reciprocal = true,
                      .on_demand = true,
                      .plausible = {0.05, 1e6,
                                    "an autofocus settles in tenths of a second, a camera warms up "
                                    "in an hour"}}},
      .help =
          "The focal length drifts with time: a camera or a lens that warms up, or a focus that "
          "creeps.",
      .formula = "f (1 + per_s tau (1 - exp(-t / tau))), t since the set's first time",
      .signature = "radial from the principal point, growing with time",
      .example = "focal_drift: {per_s: 0.0001}",
      .needs = {Need::frame_times},
      .advice = {{kPoints | kFrames,
                  {"focus_variation"},
                  "Take views in an order of distances and angles that time does not follow: a "
                  "drift goes with time, an autofocus with the scene."},
                 {kPoints | kFrames,
                  {},
                  "the same scene cold and warm, over the time in which a camera warms up"}},
      .geometry =
          [](Values p, ImagePoint& point) {
            const double way_s =
                std::isfinite(p[1]) ? p[1] * (1 - maths::exp(-point.t_s / p[1])) : point.t_s;
            const double factor = 1 + p[0] * way_s;
            point.fx *= factor, point.fy *= factor;
          },
      .proof = {{.values = {0.0001, INFINITY},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}, {"t_s", 300}},
                 .expected = {{"u_px", 128.052}, {"v_px", 44.8024}},
                 .source = "python: 160 * 1.03 * 0.24 + 88.5, 162 * 1.03 * -0.16 + 71.5"},
                {.values = {-0.0002, 40},
                 .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}, {"t_s", 100}},
                 .expected = {{"u_px", -6.79504127894316}, {"v_px", 135.824152863287}},
                 .source = "python: 160 * -0.6 * (1 - 0.008 * (1 - math.exp(-2.5))) + 88.5, 162 * "
                           "0.4 * (1 - 0.008 * (1 - math.exp(-2.5))) + 71.5"}},
  };
}

}  // namespace seam::effects
