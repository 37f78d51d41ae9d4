#include "effects/effect.h"
#include "effects/stages/target.h"

namespace seam::effects {

EffectDefinition board_scale() {
  const auto share = [](const char* name, const char* help, std::vector<Need> needs = {}) {
    return Parameter{
        .name = name,
        .min = -0.2,
        .max = 0.2,
        .scale = 1e-3,
        .help = help,
        .needs = std::move(needs),
        .plausible = {-0.08, 0.08,
                      "printers are within 1 %, a page that was made to fit within 6"}};
  };
  return {
      .name = "board_scale",
      .stage = Stage::target,
      .kinds = kPoints,
      .parameters = {share("x_scale", "By how much the board is longer along x, relative."),
                     share("y_scale", "The same along y.", {Need::known_scale}),
                     share("shear",
                           "By how much x grows along y, relative: corners are not "
                           "square.")},
      .help =
          "A printed target is stretched in its plane, differently along its sides; where poses "
          "are unknown, one scale alone is that of the distance.",
      .formula = "x (1 + x_scale) + shear y, y (1 + y_scale), from the board's middle",
      .signature = "depends on the point, in proportion to its place on the board",
      .example = "board_scale: {x_scale: 0.001, shear: -0.0005}",
      .needs = {Need::flat_target},
      .advice = {{kPoints,
                  {},
                  "A stretched board looks like unequal focal lengths where it is always held the "
                  "same way up: turn it by a quarter in half of the views."}},
      .target =
          [](Values p, TargetShape& shape) {
            shape.x_scale += p[0];
            shape.y_scale += p[1];
            shape.shear += p[2];
          },
      .proof = {{.values = {0.001, -0.002, 0.0005},
                 .given = {{"x_m", 0.12}, {"y_m", -0.08}, {"z_m", 0.001}, {"half_m", 0.2}},
                 .expected = {{"x_m", 0.12008}, {"y_m", -0.07984}, {"z_m", 0.001}},
                 .source = "python: 0.12 * 1.001 + 0.0005 * -0.08, -0.08 * (1 - 0.002), z_m"},
                {.values = {0, 0, 0.01},
                 .given = {{"y_m", 0.3}},
                 .expected = {{"x_m", 0.003}, {"y_m", 0.3}},
                 .source = "python: 0.003, 0.3"}},
  };
}

}  // namespace seam::effects
