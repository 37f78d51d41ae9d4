#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition focal_length_error() {
  return {
      .name = "focal_length_error",
      .stage = Stage::geometry,
      .kinds = kPoints | kRanges | kFrames,
      .parameters = {{.name = "fx_scale",
                      .min = -0.5,
                      .max = 0.5,
                      .scale = 0.01,
                      .help = "Relative error of the focal length along rows."},
                     {.name = "fy_scale",
                      .min = -0.5,
                      .max = 0.5,
                      .scale = 0.01,
                      .help = "Relative error of the focal length along columns."}},
      .help = "The focal length differs from the stated one.",
      .formula = "fx (1 + scale)",
      .signature = "displacement proportional to the offset from the centre",
      .example = "focal_length_error: {fx_scale: 0.01, fy_scale: 0.01}",
      .geometry =
          [](Values p, ImagePoint& point) {
            point.fx *= 1 + p[0];
            point.fy *= 1 + p[1];
          },
      .proof = {{.values = {0.01, -0.02},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
                 .expected = {{"u_px", 127.284}, {"v_px", 46.0984}},
                 .source = "python: 160 * 1.01 * 0.24 + 88.5, 162 * 0.98 * -0.16 + 71.5"},
                {.values = {-0.1, 0},
                 .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}},
                 .expected = {{"u_px", 2.10000000000001}, {"v_px", 136.3}},
                 .source = "python: 160 * 0.9 * -0.6 + 88.5, 162 * 0.4 + 71.5"}},
  };
}

}  // namespace seam::effects
