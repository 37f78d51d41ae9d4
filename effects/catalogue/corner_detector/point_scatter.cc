#include "effects/stages/noise.h"

namespace seam::effects {

EffectDefinition point_scatter() {
  return {
      .name = "point_scatter",
      .stage = Stage::corner_detector,
      .kinds = kPoints,
      .parameters =
          {{.name = "fraction",
            .min = 0,
            .max = 0.9,
            .scale = 0.05,
            .help = "Share of the points whose detection failed.",
            .plausible =
                {0, 0.25,
                 "1 to 10 % of data are gross errors (Hampel 1986): a quarter is not rare"}},
           {.name = "sigma_px",
            .min = 0,
            .max = 1000,
            .scale = 1,
            .help = "Standard deviation of the further error of these, in u and in v, pixels."}},
      .help =
          "The detector fails now and then: a fraction of the points is far less exact than the "
          "others (robust noise).",
      .formula = "with probability fraction: variance of u and of v + sigma_px^2",
      .signature = "few residuals are far larger than the others, in no order",
      .example = "point_scatter: {fraction: 0.03, sigma_px: 1.5}",
      .spread_only = true,
      .errors = Errors::now_and_then,
      .unknown_cause = true,
      .starts = {{kPoints,
                  StartSearch::best_listed,
                  {{0.01, 0.5}, {0.01, 3}, {0.05, 0.5}, {0.05, 3}, {0.2, 0.5}, {0.2, 3}}}},
      .noise =
          [](Values p, Noise& noise) {
            noise.point_scatter = {p[0], p[1]};
          },
      .proof = {{.values = {0.03, 1.5},
                 .given = {{"x_m", 0.1}, {"z_m", 1}},
                 .expected = {{"scatter_variance_px2", 0.0675}},
                 .source = "python: p[0] * p[1]**2"},
                {.values = {0.2, 4},
                 .given = {{"x_m", 0.1}, {"z_m", 1}},
                 .expected = {{"scatter_variance_px2", 3.2}},
                 .source = "python: p[0] * p[1]**2"}},
  };
}

}  // namespace seam::effects
