#include <cmath>

#include "effects/effect.h"
#include "effects/stages/target.h"

namespace seam::effects {

EffectDefinition target_scatter() {
  return {
      .name = "target_scatter",
      .stage = Stage::target,
      .kinds = kPoints,
      .parameters =
          {{.name = "sigma_m",
            .min = 0,
            .max = 0.05,
            .scale = 1e-4,
            .help = "One sigma of each coordinate of a point's displacement, m.",
            .plausible = {0, 0.02,
                          "printed corners lie within 0.2 mm, marks placed by hand within 1 cm"}}},
      .help =
          "Each point of the target is displaced by its own fixed vector, the same in all "
          "views, which is estimated with it.",
      .formula = "p + d, each coordinate of d from N(0, sigma_m^2), the same in all views",
      .signature = "depends on the point, each for itself",
      .example = "target_scatter: {sigma_m: 0.0001}",
      .spread_only = true,
      .draws_estimated = true,
      .unknown_cause = true,
      .needs = {Need::several_views},
      .starts = {{kPoints, StartSearch::listed, {{1e-4}}}},
      .advice = {{kPoints,
                  {},
                  "Displaced points show in many views of different tilt; with few they look like "
                  "noise or like the lens."}},
      .target =
          [](Values p, TargetShape& shape) {
            shape.scatter_sigma_m =
                std::sqrt(shape.scatter_sigma_m * shape.scatter_sigma_m + p[0] * p[0]);
          },
      .proof = {{.values = {0.0001},
                 .given = {{"x_m", 0.12}, {"y_m", -0.08}, {"z_m", 0.001}, {"half_m", 0.2}},
                 .expected = {{"x_m", 0.12}, {"z_m", 0.001}, {"scatter_m", 0.0001}},
                 .source = "python: x_m, z_m, p[0]"},
                {.values = {0.002}, .expected = {{"scatter_m", 0.002}}, .source = "python: p[0]"}},
  };
}

}  // namespace seam::effects
