#include "effects/stages/wander.h"

namespace seam::effects {

EffectDefinition bearing_wander() {
  return {
      .name = "bearing_wander",
      .stage = Stage::detector,
      .kinds = kLandmarks,
      .parameters = wander_parameters("sigma_rad", "radians", 1, 0.01),
      .help = "The error of a bearing wanders, each landmark's on its own.",
      .formula = "Ornstein-Uhlenbeck: covariance sigma_rad^2 exp(-lag / tau_s)",
      .signature = "neighbours on a landmark's track agree, other landmarks do not",
      .example = "bearing_wander: {sigma_rad: 0.01, tau_s: 2}",
      .spread_only = true,
      .errors = Errors::together,
      .unknown_cause = true,
      .needs = {Need::bearings},
      .starts = wander_starts(kLandmarks, 0.01),
      .advice = {{kLandmarks,
                  {"heading_wander"},
                  "several landmarks in view at once: a heading moves all of them"},
                 {kLandmarks,
                  {"landmark_bias"},
                  "longer tracks of each landmark: a bias stays, a wander comes back"}},
      .noise =
          [](Values p, Noise& noise) {
            if (p[0] > 0) noise.bearing.push_back({p[0], p[1]});
          },
      .proof = {{.values = {0.01, 2},
                 .given = {{"lag_s", 1}},
                 .expected = {{"bearing_covariance_rad2", 6.06530659712633e-05}},
                 .source = "python: p[0]**2 * math.exp(-lag_s / p[1])"},
                {.values = {0.3, 5},
                 .given = {{"lag_s", 10}},
                 .expected = {{"bearing_covariance_rad2", 0.0121801754912951},
                              {"heading_covariance_rad2", 0}},
                 .source = "python: p[0]**2 * math.exp(-lag_s / p[1]), 0"}},
  };
}

}  // namespace seam::effects
