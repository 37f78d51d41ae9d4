#include "effects/stages/noise.h"

namespace seam::effects {

EffectDefinition landmark_delay() {
  return {
      .name = "landmark_delay",
      .stage = Stage::detector,
      .kinds = kLandmarks,
      .parameters = {{.name = "sigma_m",
                      .min = 0,
                      .max = 10,
                      .scale = 0.02,
                      .help = "Standard deviation of a landmark's constant range error, metres.",
                      .plausible = {0, 1,
                                    "Decawave's note APS014: 0.3 m where no delay was calibrated; "
                                    "users of its radios report up to 0.75 m"}}},
      .help =
          "All ranges of a landmark are too long or too short by a constant of its own, the same "
          "in all runs: the delay of its antenna, in metres. Each landmark's is estimated.",
      .formula = "range + d of the landmark, d from N(0, sigma_m^2), in all runs the same",
      .signature = "the mean of ranges depends on the landmark, from whichever side it is seen",
      .example = "landmark_delay: {sigma_m: 0.1}",
      .spread_only = true,
      .errors = Errors::together,
      .needs = {Need::distances},
      .starts = {{kLandmarks, StartSearch::best_listed, {{0.01}, {0.05}, {0.3}}}},
      .advice = {{kLandmarks,
                  {"landmark_scatter"},
                  "Go round each landmark, or between them: a delay makes its ranges too long from "
                  "every side, a wrong place too long from one side and too short from the other."},
                 {kLandmarks,
                  {"landmark_bias"},
                  "Measure several runs: a delay stays the same from run to run."}},
      .noise = [](Values p, Noise& noise) { noise.delay_variance += p[0] * p[0]; },
      .proof = {{.values = {0.1},
                 .given = {{"range_m", 2}},
                 .expected = {{"delay_sigma_m", 0.1}, {"place_sigma_m", 0}},
                 .source = "python: p[0], 0"},
                {.values = {0.3},
                 .given = {{"range_m", 1}, {"lag_s", 5}},
                 .expected = {{"delay_sigma_m", 0.3}, {"range_covariance_m2", 0}},
                 .source = "python: p[0], 0"}},
  };
}

}  // namespace seam::effects
