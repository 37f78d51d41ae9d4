#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition pinhole() {
  const auto length = [](const char* name, const char* help) {
    return Parameter{.name = name,
                     .neutral = 0,
                     .min = 1,
                     .max = 1e5,
                     .scale = 100,
                     .help = help,
                     .required = true};
  };
  const auto centre = [](const char* name, const char* help) {
    return Parameter{.name = name,
                     .neutral = 0,
                     .min = -1e5,
                     .max = 1e5,
                     .scale = 10,
                     .help = help,
                     .required = true};
  };
  return {
      .name = "pinhole",
      .stage = Stage::geometry,
      .kinds = kPoints | kRanges | kFrames,
      .parameters = {length("fx_px", "Focal length along rows, pixels."),
                     length("fy_px", "Focal length along columns, pixels."),
                     centre("cx_px", "Column of the principal point, pixels."),
                     centre("cy_px", "Row of the principal point, pixels.")},
      .help = "The ideal perspective camera that every other geometric effect acts upon.",
      .formula = "u = fx x + cx, v = fy y + cy",
      .signature = "none: it is the base",
      .example = "pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}",
      .has_neutral = false,
      .geometry =
          [](Values p, ImagePoint& point) {
            point.fx = p[0], point.fy = p[1], point.cx = p[2], point.cy = p[3];
          },
  };
}

}  // namespace seam::effects
