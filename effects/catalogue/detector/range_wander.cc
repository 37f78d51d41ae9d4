#include "effects/stages/noise.h"

namespace seam::effects {

EffectDefinition range_wander() {
  return {
      .name = "range_wander",
      .stage = Stage::detector,
      .kinds = kLandmarks,
      .parameters = {{.name = "sigma_m",
                      .min = 0,
                      .max = 5,
                      .scale = 0.02,
                      .help = "Standard deviation of the error that wanders, metres."},
                     {.name = "tau_s",
                      .min = 0,
                      .max = 10000,
                      .scale = 1,
                      .help = "Its memory, seconds: after so long a third is left of it."}},
      .help =
          "The error of a range wanders: for a while a landmark is seen too far, then too near.",
      .formula = "Ornstein-Uhlenbeck: covariance sigma_m^2 exp(-lag / tau_s)",
      .signature = "neighbours on a landmark's track agree",
      .example = "range_wander: {sigma_m: 0.02, tau_s: 2}",
      .spread_only = true,
      .errors = Errors::together,
      .needs = {Need::distances},
      .starts = {{kLandmarks,
                  StartSearch::best_listed,
                  {{0.002, 0.3},
                   {0.002, 2},
                   {0.002, 15},
                   {0.02, 0.3},
                   {0.02, 2},
                   {0.02, 15},
                   {0.2, 0.3},
                   {0.2, 2},
                   {0.2, 15}}}},
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
