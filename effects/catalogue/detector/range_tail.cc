#include "effects/stages/noise.h"

namespace seam::effects {

EffectDefinition range_tail() {
  return {
      .name = "range_tail",
      .stage = Stage::detector,
      .kinds = kLandmarks,
      .parameters =
          {{.name = "fraction",
            .min = 0,
            .max = 0.9,
            .scale = 0.05,
            .help = "Share of the ranges that are too long.",
            .plausible = {0, 0.6,
                          "reflections reach a receiver behind walls in up to half of the ranges"}},
           {.name = "scale_m",
            .min = 0,
            .max = 20,
            .scale = 0.3,
            .help = "Mean of what these are too long by, metres."}},
      .help =
          "A fraction of the ranges is too long: reflections, or another thing behind the "
          "landmark.",
      .formula = "with probability fraction: range + an exponential of mean scale_m",
      .signature = "some ranges are far too long, none so much too short",
      .example = "range_tail: {fraction: 0.03, scale_m: 0.4}",
      .spread_only = true,
      .errors = Errors::now_and_then,
      .needs = {Need::distances},
      .starts = {{kLandmarks,
                  StartSearch::best_listed,
                  {{0.01, 0.1}, {0.01, 1}, {0.05, 0.1}, {0.05, 1}, {0.2, 0.1}, {0.2, 1}}}},
      .noise =
          [](Values p, Noise& noise) {
            noise.range_tail = {p[0], p[1]};
          },
      .proof = {{.values = {0.03, 0.4},
                 .given = {{"range_m", 2}},
                 .expected = {{"tail_mean_m", 0.012}, {"tail_variance_m2", 0.009456}},
                 .source = "python: p[0] * p[1], p[0] * (2 - p[0]) * p[1]**2"},
                {.values = {0.2, 1.5},
                 .expected = {{"tail_mean_m", 0.3}, {"tail_variance_m2", 0.81}},
                 .source = "python: p[0] * p[1], p[0] * (2 - p[0]) * p[1]**2"}},
  };
}

}  // namespace seam::effects
