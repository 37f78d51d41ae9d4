#include "effects/stages/wander.h"

namespace seam::effects {

EffectDefinition heading_wander() {
  return {
      .name = "heading_wander",
      .stage = Stage::detector,
      .kinds = kLandmarks,
      .parameters = wander_parameters("sigma_rad", "radians", 1, 0.01),
      .help = "The measured heading of the robot wanders: one error for all bearings of a run.",
      .formula = "Ornstein-Uhlenbeck: covariance sigma_rad^2 exp(-lag / tau_s)",
      .signature = "bearings of all landmarks are off together, neighbours in time agree",
      .example = "heading_wander: {sigma_rad: 0.01, tau_s: 2}",
      .spread_only = true,
      .errors = Errors::together,
      .unknown_cause = true,
      .needs = {Need::bearings},
      .starts = wander_starts(kLandmarks, 0.01),
      .noise =
          [](Values p, Noise& noise) {
            if (p[0] > 0) noise.heading.push_back({p[0], p[1]});
          },
      .proof = {{.values = {0.024, 2.3},
                 .given = {{"lag_s", 2.3}},
                 .expected = {{"heading_covariance_rad2", 0.000211898558114751},
                              {"bearing_covariance_rad2", 0}},
                 .source = "python: p[0]**2 / math.e, 0"},
                {.values = {0.1, 1},
                 .given = {{"lag_s", 0.25}},
                 .expected = {{"heading_covariance_rad2", 0.00778800783071405}},
                 .source = "python: p[0]**2 * math.exp(-lag_s / p[1])"}},
  };
}

}  // namespace seam::effects
