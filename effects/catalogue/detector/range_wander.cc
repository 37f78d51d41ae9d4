#include "effects/stages/wander.h"

namespace seam::effects {

EffectDefinition range_wander() {
  return {
      .name = "range_wander",
      .stage = Stage::detector,
      .kinds = kLandmarks,
      .parameters = wander_parameters("sigma_m", "metres", 5, 0.02),
      .help =
          "The error of a range wanders: for a while a landmark is seen too far, then too near.",
      .formula = "Ornstein-Uhlenbeck: covariance sigma_m^2 exp(-lag / tau_s)",
      .signature = "neighbours on a landmark's track agree",
      .example = "range_wander: {sigma_m: 0.02, tau_s: 2}",
      .spread_only = true,
      .errors = Errors::together,
      .unknown_cause = true,
      .needs = {Need::distances},
      .starts = wander_starts(kLandmarks, 0.02),
      .advice = {{kLandmarks,
                  {"landmark_bias"},
                  "longer tracks of each landmark: a bias stays, a wander comes back"}},
      .noise =
          [](Values p, Noise& noise) {
            if (p[0] > 0) noise.range.push_back({p[0], p[1]});
          },
      .proof = {{.values = {0.05, 2.5},
                 .given = {{"lag_s", 0.5}},
                 .expected = {{"range_covariance_m2", 0.00204682688269495}},
                 .source = "python: p[0]**2 * math.exp(-lag_s / p[1])"},
                {.values = {0.2, 0.4},
                 .given = {{"lag_s", 1}},
                 .expected = {{"range_covariance_m2", 0.00328339994495595}},
                 .source = "python: p[0]**2 * math.exp(-lag_s / p[1])"}},
  };
}

}  // namespace seam::effects
