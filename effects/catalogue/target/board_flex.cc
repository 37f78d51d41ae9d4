#include <cmath>

#include "effects/effect.h"
#include "effects/stages/target.h"

namespace seam::effects {

EffectDefinition board_flex() {
  return {
      .name = "board_flex",
      .stage = Stage::target,
      .kinds = kPoints,
      .parameters = {{.name = "sigma_m",
                      .min = 0,
                      .max = 0.05,
                      .scale = 1e-4,
                      .help = "One sigma of a view's bending, m.",
                      .plausible = {0, 0.01, "a board in the hand bends by millimetres"}}},
      .help =
          "A board bends a little differently in each view: one amplitude a view along the "
          "shape of `board_warp` (of unit size; alike both ways where there is none).",
      .formula =
          "z + f (x_m (1 - a^2) + y_m (1 - b^2)) / sqrt(x_m^2 + y_m^2), f from N(0, "
          "sigma_m^2) for each view",
      .signature = "smooth over the board, another in each view",
      .example = "board_flex: {sigma_m: 0.0001}",
      .spread_only = true,
      .draws_estimated = true,
      .needs = {Need::flat_target, Need::several_views, Need::still_views},
      .starts = {{kPoints, StartSearch::listed, {{1e-4}}}},
      .target =
          [](Values p, TargetShape& shape) {
            shape.flex_sigma_m = std::sqrt(shape.flex_sigma_m * shape.flex_sigma_m + p[0] * p[0]);
          },
      .proof = {{.values = {0.0002},
                 .given = {{"x_m", 0.12},
                           {"y_m", -0.08},
                           {"z_m", 0.001},
                           {"half_m", 0.2},
                           {"flex_m", 0.001}},
                 .expected = {{"z_m", 0.00204651803615609}, {"flex_sigma_m", 0.0002}},
                 .source = "python: z_m + 0.001 * (2 - 0.6**2 - 0.4**2) / math.sqrt(2), p[0]"},
                {.values = {0.001},
                 .given = {{"half_m", 0.1}, {"flex_m", -0.002}},
                 .expected = {{"z_m", -0.00282842712474619}, {"flex_sigma_m", 0.001}},
                 .source = "python: -0.002 * math.sqrt(2), p[0]"}},
  };
}

}  // namespace seam::effects
