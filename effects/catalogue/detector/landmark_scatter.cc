#include "effects/stages/noise.h"

namespace seam::effects {

EffectDefinition landmark_scatter() {
  return {
      .name = "landmark_scatter",
      .stage = Stage::detector,
      .kinds = kLandmarks,
      .parameters = {{.name = "sigma_m",
                      .min = 0,
                      .max = 10,
                      .scale = 0.02,
                      .help = "Standard deviation of a landmark's x and of its y, metres."}},
      .help =
          "Each landmark lies off its place in the map by a vector of its own, the same in all "
          "runs: places that were measured badly. Results list the displacements beside the sigma.",
      .formula = "x and y of each landmark displaced by independent errors of sigma_m",
      .signature = "the mean depends on the landmark, and on the side from which it is seen",
      .example = "landmark_scatter: {sigma_m: 0.03}",
      .spread_only = true,
      .errors = Errors::together,
      .needs = {Need::landmark_places},
      .starts = {{kLandmarks, StartSearch::best_listed, {{0.01}, {0.05}, {0.3}}}},
      .advice = {{kLandmarks, {}, "See each landmark from all sides, in several runs."}},
      .noise = [](Values p, Noise& noise) { noise.place_variance += p[0] * p[0]; },
      .proof = {{.values = {0.03},
                 .given = {{"range_m", 2}},
                 .expected = {{"place_sigma_m", 0.03}, {"range_m", 2}},
                 .source = "python: p[0], range_m"},
                {.values = {0.2},
                 .given = {{"range_m", 1}},
                 .expected = {{"place_sigma_m", 0.2}, {"range_covariance_m2", 0}},
                 .source = "python: p[0], 0"}},
  };
}

}  // namespace seam::effects
