#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition principal_point_offset() {
  return {
      .name = "principal_point_offset",
      .stage = Stage::geometry,
      .kinds = kPoints | kRanges | kFrames,
      .parameters = {{.name = "du_px",
                      .min = -500,
                      .max = 500,
                      .scale = 2,
                      .help = "Shift along rows, pixels."},
                     {.name = "dv_px",
                      .min = -500,
                      .max = 500,
                      .scale = 2,
                      .help = "Shift along columns, pixels."}},
      .help = "The principal point differs from the stated one.",
      .formula = "cx + du, cy + dv",
      .signature = "constant",
      .example = "principal_point_offset: {du_px: 2.5}",
      .geometry =
          [](Values p, ImagePoint& point) {
            point.cx += p[0];
            point.cy += p[1];
          },
  };
}

}  // namespace seam::effects
