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
  };
}

}  // namespace seam::effects
