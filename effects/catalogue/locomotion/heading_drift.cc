#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

EffectDefinition heading_drift() {
  return {
      .name = "heading_drift",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {{.name = "rad_per_m",
                      .min = -5,
                      .max = 5,
                      .scale = 0.05,
                      .help = "Turn for each metre of path, radians; positive: to the left.",
                      .plausible = {-2, 2, "a walk in a circle of half a metre"}}},
      .help = "Legs that push unevenly turn the body while it walks.",
      .formula = "omega + rad_per_m * sqrt(vx^2 + vy^2)",
      .signature = "heading error with distance",
      .example = "heading_drift: {rad_per_m: 0.05}",
      .needs = {Need::commanded_walk, Need::path},
      .advice =
          {{kOdometry,
            {},
            "Walk several metres straight on, and turn on the spot: a drift turns the heading "
            "with the way, and not in a turn on the spot."}},
      .locomotion = [](Values p, Locomotion& walk) { walk.heading_rad_per_m += p[0]; },
      .proof = {{.values = {0.05},
                 .given = {{"vx_mps", 0.2}, {"for_s", 5}},
                 .expected = {{"x_m", 0.999583385413567},
                              {"y_m", 0.0249947921006743},
                              {"theta_rad", 0.05}},
                 .source = "python: math.sin(p[0]) / p[0], (1 - math.cos(p[0])) / p[0], p[0]"},
                {.values = {-1},
                 .given = {{"vx_mps", 0.3}, {"vy_mps", 0.4}, {"for_s", 2}},
                 .expected = {{"theta_rad", -1}},
                 .source = "python: p[0] * 0.5 * 2"}},
  };
}

}  // namespace seam::effects
