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
      .base = Base::projection,
      .geometry =
          [](Values p, ImagePoint& point) {
            point.fx = p[0], point.fy = p[1], point.cx = p[2], point.cy = p[3];
          },
      .proof = {{.values = {161.9, 162.5, 88, 71},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
                 .expected = {{"u_px", 126.856}, {"v_px", 45}},
                 .source = "python: p[0] * 0.24 + p[2], p[1] * -0.16 + p[3]"},
                {.values = {300, 310, 159.5, 119.5},
                 .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}},
                 .expected = {{"u_px", -20.5}, {"v_px", 243.5}},
                 .source = "python: p[0] * -0.6 + p[2], p[1] * 0.4 + p[3]"}},
  };
}

}  // namespace seam::effects
