#include "effects/stages/wander.h"

namespace seam::effects {

EffectDefinition joint_wander() {
  return {
      .name = "joint_wander",
      .stage = Stage::joint,
      .kinds = kJoints,
      .parameters = wander_parameters("sigma_rad", "radians", 1, 0.002),
      .help = "The error of a logged joint wanders in time.",
      .formula = "Ornstein-Uhlenbeck: covariance sigma_rad^2 exp(-lag / tau_s)",
      .signature = "neighbours in a run agree",
      .example = "joint_wander: {sigma_rad: 0.002, tau_s: 2}",
      .spread_only = true,
      .errors = Errors::together,
      .unknown_cause = true,
      .starts = wander_starts(kJoints, 0.002),
      .noise =
          [](Values p, Noise& noise) {
            if (p[0] > 0) noise.joint.push_back({p[0], p[1]});
          },
      .proof = {{.values = {0.004, 0.5},
                 .given = {{"lag_s", 0.25}},
                 .expected = {{"joint_covariance_rad2", 9.70449055540213e-06}},
                 .source = "python: p[0]**2 * math.exp(-lag_s / p[1])"},
                {.values = {0.02, 3},
                 .given = {{"lag_s", 1.5}},
                 .expected = {{"joint_covariance_rad2", 0.000242612263885053}},
                 .source = "python: p[0]**2 * math.exp(-lag_s / p[1])"}},
  };
}

}  // namespace seam::effects
