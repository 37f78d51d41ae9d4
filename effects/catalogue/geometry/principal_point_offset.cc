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
      .family = Family::pointing,
      .geometry =
          [](Values p, ImagePoint& point) {
            point.cx += p[0];
            point.cy += p[1];
          },
      .proof = {{.values = {2.5, -1.5},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
                 .expected = {{"u_px", 129.4}, {"v_px", 44.08}},
                 .source = "python: 160 * 0.24 + 91, 162 * -0.16 + 70"},
                {.values = {0, 4},
                 .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}},
                 .expected = {{"u_px", -7.5}, {"v_px", 140.3}},
                 .source = "python: 160 * -0.6 + 88.5, 162 * 0.4 + 75.5"}},
  };
}

}  // namespace seam::effects
