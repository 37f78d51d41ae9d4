#include "effects/stages/noise.h"

namespace seam::effects {

EffectDefinition pose_noise() {
  return {
      .name = "pose_noise",
      .stage = Stage::locomotion,
      .kinds = kOdometry,
      .parameters = {{.name = "xy_sigma_m",
                      .min = 0,
                      .max = 1,
                      .scale = 0.001,
                      .help = "Spread of x and of y at rest, metres."},
                     {.name = "theta_sigma_rad",
                      .min = 0,
                      .max = 1,
                      .scale = 0.002,
                      .help = "Spread of the heading at rest, radians."},
                     {.name = "per_mps",
                      .min = 0,
                      .max = 1000,
                      .scale = 5,
                      .help = "How much all of it grows with the speed: by so many times itself "
                              "for each metre a second."},
                     {.name = "per_radps",
                      .min = 0,
                      .max = 1000,
                      .scale = 2,
                      .help = "The same for each radian a second of turning."}},
      .help = "Measured poses are worse while the robot moves.",
      .formula =
          "sigma * (1 + per_mps * speed + per_radps * abs(omega)), each row, beside the noise of "
          "the set",
      .signature = "spread grows with the speed, not with the distance",
      .example = "pose_noise: {xy_sigma_m: 0.001, theta_sigma_rad: 0.002, per_mps: 10}",
      .spread_only = true,
      .errors = Errors::independent,
      .unknown_cause = true,
      .starts = {{kOdometry,
                  StartSearch::best_listed,
                  {{0.0003, 0.0006, 0.5, 0.2},
                   {0.0003, 0.0006, 10, 0.2},
                   {0.0003, 0.0006, 0.5, 4},
                   {0.003, 0.006, 0.5, 0.2},
                   {0.003, 0.006, 10, 0.2},
                   {0.003, 0.006, 0.5, 4},
                   {0.03, 0.06, 0.5, 0.2},
                   {0.03, 0.06, 10, 0.2},
                   {0.03, 0.06, 0.5, 4}}}},
      .advice = {{kOdometry,
                  {"walk_noise"},
                  "rows at rest after each walk: a slip stays, a bad measurement does not"}},
      .noise =
          [](Values p, Noise& noise) {
            if (p[0] > 0 || p[1] > 0) noise.pose.push_back({p[0], p[1], p[2], p[3]});
          },
      .proof = {{.values = {0.001, 0.002, 10, 1.5},
                 .given = {{"vx_mps", 0.3}, {"vy_mps", -0.4}, {"omega_radps", -0.8}, {"for_s", 2}},
                 .expected = {{"pose_xy_sigma_m", 0.0072}, {"pose_theta_sigma_rad", 0.0144}},
                 .source = "python: p[0] * (1 + p[2] * 0.5 + p[3] * 0.8), p[1] * (1 + p[2] * 0.5 + "
                           "p[3] * 0.8)"},
                {.values = {0.04, 0.05, 2, 0.5},
                 .given = {{"vx_mps", 0.2}, {"omega_radps", 1}, {"for_s", 2}},
                 .expected = {{"pose_xy_sigma_m", 0.076}, {"pose_theta_sigma_rad", 0.095}},
                 .source = "python: p[0] * 1.9, p[1] * 1.9"}},
  };
}

}  // namespace seam::effects
