#include <cmath>

#include "effects/effect.h"
#include "effects/stages/target.h"

namespace seam::effects {

EffectDefinition board_sway() {
  return {
      .name = "board_sway",
      .stage = Stage::target,
      .kinds = kPoints,
      .parameters = {{.name = "shift_sigma_m",
                      .min = 0,
                      .max = 0.1,
                      .scale = 1e-4,
                      .help = "One sigma of each coordinate of the shift, m.",
                      .plausible = {0, 0.03, "a hand at 0.5 m/s, exposures 30 ms apart: 15 mm"}},
                     {.name = "turn_sigma_rad",
                      .min = 0,
                      .max = 0.1,
                      .scale = 1e-3,
                      .help = "One sigma of the turn about each axis, rad.",
                      .plausible = {0, 0.05, "a hand at 1 rad/s, exposures 30 ms apart: 0.03"}}},
      .help =
          "The cameras of a rig do not see a frame at once, or one gives in its mount: before each "
          "camera but the first the target is shifted and turned a little, otherwise in each "
          "frame.",
      .formula =
          "p + s + w x p from the target's middle; each coordinate of s from N(0, shift_sigma_m^2) "
          "and of w from N(0, turn_sigma_rad^2), for each frame and camera but the first",
      .signature = "one camera's view of a frame is moved as a whole, otherwise in each frame",
      .example = "board_sway: {shift_sigma_m: 0.0005, turn_sigma_rad: 0.001}",
      .spread_only = true,
      .draws_estimated = true,
      .needs = {Need::several_cameras, Need::several_views, Need::still_views},
      .starts = {{kPoints, StartSearch::listed, {{2e-4, 1e-3}}}},
      .advice = {{kPoints,
                  {},
                  "A target that is fixed while the cameras see it, or cameras that are released "
                  "together, leave no sway but that of a mount."}},
      .target =
          [](Values p, TargetShape& shape) {
            const auto beside = [](double a, double b) { return std::sqrt(a * a + b * b); };
            shape.sway_shift_sigma_m = beside(shape.sway_shift_sigma_m, p[0]);
            shape.sway_turn_sigma_rad = beside(shape.sway_turn_sigma_rad, p[1]);
          },
      .proof = {{.values = {0.0004, 0.002},
                 .given = {{"x_m", 0.12},
                           {"y_m", -0.08},
                           {"z_m", 0.001},
                           {"half_m", 0.2},
                           {"shift_x_m", 0.001},
                           {"turn_z_rad", 0.003}},
                 .expected = {{"x_m", 0.12124},
                              {"y_m", -0.07964},
                              {"z_m", 0.001},
                              {"sway_shift_sigma_m", 0.0004},
                              {"sway_turn_sigma_rad", 0.002}},
                 .source = "python: x_m + 0.001 - 0.003 * y_m, y_m + 0.003 * x_m, z_m, p[0], p[1]"},
                {.values = {0, 0.001},
                 .expected = {{"sway_shift_sigma_m", 0}, {"sway_turn_sigma_rad", 0.001}},
                 .source = "python: 0, p[1]"}},
  };
}

}  // namespace seam::effects
