#include <cmath>

#include "effects/effect.h"
#include "effects/stages/target.h"

namespace seam::effects {

EffectDefinition view_motion() {
  return {
      .name = "view_motion",
      .stage = Stage::target,
      .kinds = kPoints,
      .parameters = {{.name = "turn_sigma_rad",
                      .min = 0,
                      .max = 0.1,
                      .scale = 1e-3,
                      .help = "One sigma of the turn about each axis in one image's time, rad.",
                      .plausible = {0, 0.05, "a hand at 1 rad/s, rows read in 30 ms: 0.03"}}},
      .help =
          "The camera moved while the rows of its images were read one after the other: each view "
          "has a turn of its own, which is estimated with its pose. A still view shows the product "
          "of speed and read-out time alone, and a way to the side looks like a turn.",
      .formula =
          "p + b w x p in the camera's frame, b = v / height - 1/2 of the row v; each coordinate "
          "of w from N(0, turn_sigma_rad^2), for each view",
      .signature = "each view is sheared and stretched along its rows, otherwise in each view",
      .example = "view_motion: {turn_sigma_rad: 0.005}",
      .spread_only = true,
      .draws_estimated = true,
      .needs = {Need::unknown_poses, Need::several_views, Need::still_views},
      .starts = {{kPoints, StartSearch::listed, {{3e-3}}}},
      .advice = {{kPoints,
                  {},
                  "The camera moved while its rows were read: hold it still for each view, or "
                  "state the read-out time (rolling_shutter) and say motion: constant_velocity, or "
                  "take a video and say motion: spline."},
                 {kOutcomes,
                  {},
                  "it is one draw for each view of a calibration: leave it out; the robot's own "
                  "motion moves the camera while rows are read (rolling_shutter)"}},
      .target =
          [](Values p, TargetShape& shape) {
            shape.motion_sigma_rad =
                std::sqrt(shape.motion_sigma_rad * shape.motion_sigma_rad + p[0] * p[0]);
          },
      .proof = {{.values = {0.005},
                 .given = {{"x_m", 0.12}, {"y_m", -0.08}, {"turn_z_rad", 0.003}},
                 .expected = {{"x_m", 0.12024}, {"y_m", -0.07964}, {"motion_sigma_rad", 0.005}},
                 .source = "python: x_m - 0.003 * y_m, y_m + 0.003 * x_m, p[0]"},
                {.values = {0.01},
                 .expected = {{"motion_sigma_rad", 0.01}},
                 .source = "python: p[0]"}},
  };
}

}  // namespace seam::effects
