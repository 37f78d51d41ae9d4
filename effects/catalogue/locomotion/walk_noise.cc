#include <cmath>

#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

EffectDefinition walk_noise() {
  return {
      .name = "walk_noise",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters =
          {{.name = "xy_sigma",
            .min = 0,
            .max = 2,
            .scale = 0.01,
            .help = "Spread of body x and y after one metre of path, metres per root metre.",
            .plausible = {0, 0.3, "legged robots scatter by 1 to 10 cm over a metre"}},
           {.name = "theta_sigma",
            .min = 0,
            .max = 3,
            .scale = 0.02,
            .help = "Spread of the heading after one metre of path, radians per root metre.",
            .plausible = {0, 0.6, "legged robots scatter by 1 to 15 degrees over a metre"}}},
      .help = "Every step slips a little: a random walk of position and heading.",
      .formula = "independent steps in body x, y and theta, variance sigma^2 * path length",
      .signature = "spread grows with the root of distance",
      .example = "walk_noise: {xy_sigma: 0.01, theta_sigma: 0.02}",
      .spread_only = true,
      .unknown_cause = true,
      .needs = {Need::path},
      .starts = {{kOdometry, StartSearch::listed, {{0.01, 0.02}, {0.05, 0.1}}}},
      .advice = {{kOdometry,
                  {"odometry_scale", "heading_drift"},
                  "longer walks, each started from rest"},
                 {kOdometry, {}, "longer walks, each started from rest"}},
      .locomotion =
          [](Values p, Locomotion& walk) {
            walk.xy_sigma = std::sqrt(walk.xy_sigma * walk.xy_sigma + p[0] * p[0]);
            walk.theta_sigma = std::sqrt(walk.theta_sigma * walk.theta_sigma + p[1] * p[1]);
          },
      .proof = {{.values = {0.01, 0.02},
                 .given = {{"vx_mps", 0.2}, {"for_s", 5}},
                 .expected = {{"xy_sigma_m", 0.01}, {"theta_sigma_rad", 0.02}},
                 .source = "python: p[0], p[1]"},
                {.values = {0.03, 0.1},
                 .given = {{"vx_mps", 0.3}, {"vy_mps", -0.4}, {"for_s", 8}},
                 .expected = {{"xy_sigma_m", 0.06}, {"theta_sigma_rad", 0.2}},
                 .source = "python: p[0] * 2, p[1] * 2"}},
  };
}

}  // namespace seam::effects
