#include "effects/stages/noise.h"

namespace seam::effects {

EffectDefinition landmark_bias() {
  return {
      .name = "landmark_bias",
      .stage = Stage::detector,
      .kinds = kLandmarks,
      .parameters = {{.name = "range_sigma_m",
                      .min = 0,
                      .max = 5,
                      .scale = 0.02,
                      .help = "Standard deviation of the constant error of a range, metres.",
                      .needs = {Need::distances}},
                     {.name = "bearing_sigma_rad",
                      .min = 0,
                      .max = 1,
                      .scale = 0.01,
                      .help = "Standard deviation of the constant error of a bearing, radians.",
                      .needs = {Need::bearings}}},
      .help =
          "In each run each landmark has a constant error of its own: its place was measured "
          "badly, or it is seen from one side.",
      .formula = "one error of range and one of bearing for each landmark in each run",
      .signature = "the mean depends on the landmark and the run",
      .example = "landmark_bias: {range_sigma_m: 0.03, bearing_sigma_rad: 0.01}",
      .spread_only = true,
      .errors = Errors::together,
      .unknown_cause = true,
      .starts = {{kLandmarks,
                  StartSearch::best_listed,
                  {{0.02, 0.005}, {0.2, 0.05}, {0.02, 0.05}, {0.2, 0.005}}}},
      .noise =
          [](Values p, Noise& noise) {
            noise.range_bias_variance += p[0] * p[0];
            noise.bearing_bias_variance += p[1] * p[1];
          },
      .proof = {{.values = {0.03, 0.1},
                 .given = {{"lag_s", 5}},
                 .expected = {{"range_covariance_m2", 0.0009}, {"bearing_covariance_rad2", 0.01}},
                 .source = "python: p[0]**2, p[1]**2"},
                {.values = {0.2, 0.05},
                 .expected = {{"range_covariance_m2", 0.04}, {"bearing_covariance_rad2", 0.0025}},
                 .source = "python: p[0]**2, p[1]**2"}},
  };
}

}  // namespace seam::effects
