#include "effects/effect.h"
#include "effects/stages/target.h"

namespace seam::effects {

EffectDefinition board_warp() {
  return {
      .name = "board_warp",
      .stage = Stage::target,
      .kinds = kPoints,
      .parameters =
          {{.name = "x_m",
            .min = -0.1,
            .max = 0.1,
            .scale = 1e-3,
            .help = "How far the middle stands out of the plane by the bend along x, m.",
            .plausible = {-0.03, 0.03, "boards of a metre bend by up to a few centimetres"}},
           {.name = "y_m",
            .min = -0.1,
            .max = 0.1,
            .scale = 1e-3,
            .help = "The same along y, m.",
            .plausible = {-0.03, 0.03, "boards of a metre bend by up to a few centimetres"}}},
      .help = "A calibration board is bent: its points leave their plane.",
      .formula =
          "z + x_m (1 - a^2) + y_m (1 - b^2), a and b the board's coordinates scaled to "
          "-1..1",
      .signature = "depends on the point in tilted views, smooth over the board",
      .example = "board_warp: {x_m: 0.0003, y_m: -0.0001}",
      .needs = {Need::flat_target},
      .advice = {{kPoints,
                  {},
                  "A bent board looks like a lens where all views are alike: tilt the board both "
                  "ways, turn it by a quarter, and put it into every corner of the image."}},
      .target =
          [](Values p, TargetShape& shape) {
            shape.warp_x_m += p[0];
            shape.warp_y_m += p[1];
          },
      .proof = {{.values = {0.003, -0.001},
                 .given = {{"x_m", 0.12}, {"y_m", -0.08}, {"z_m", 0.001}, {"half_m", 0.2}},
                 .expected = {{"x_m", 0.12}, {"y_m", -0.08}, {"z_m", 0.00208}},
                 .source = "python: x_m, y_m, z_m + p[0] * (1 - 0.6**2) + p[1] * (1 - 0.4**2)"},
                {.values = {0, 0.002},
                 .given = {{"half_m", 0.1}},
                 .expected = {{"z_m", 0.002}},
                 .source = "python: p[1]"}},
  };
}

}  // namespace seam::effects
