#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition chromatic_aberration() {
  return {
      .name = "chromatic_aberration",
      .stage = Stage::geometry,
      .kinds = kPoints | kFrames | kRanges,
      .parameters =
          {{.name = "red_scale",
            .min = -0.1,
            .max = 0.1,
            .scale = 0.001,
            .help = "Radius of red against green, relative.",
            .plausible = {-0.02, 0.02, "lenses spread colours by up to 1 % of the radius"}},
           {.name = "blue_scale",
            .min = -0.1,
            .max = 0.1,
            .scale = 0.001,
            .help = "Radius of blue against green, relative.",
            .plausible = {-0.02, 0.02, "lenses spread colours by up to 1 % of the radius"}}},
      .help = "The lens magnifies the colours differently.",
      .formula = "red: (x, y) * (1 + red_scale), blue: (x, y) * (1 + blue_scale)",
      .signature = "colour fringes that grow outwards",
      .example = "chromatic_aberration: {red_scale: 0.002, blue_scale: -0.001}",
      .needs = {Need::colour},
      .geometry =
          [](Values p, ImagePoint& point) {
            if (point.channel == 1) return;
            const double scale = 1 + (point.channel == 0 ? p[0] : p[1]);
            point.xd *= scale;
            point.yd *= scale;
          },
      .proof = {{.values = {0.002, -0.001},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}, {"channel", 0}},
                 .expected = {{"u_px", 126.9768}, {"v_px", 45.52816}},
                 .source =
                     "python: 160 * 0.24 * (1 + p[0]) + 88.5, 162 * -0.16 * (1 + p[0]) + 71.5"},
                {.values = {0.002, -0.001},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}, {"channel", 2}},
                 .expected = {{"u_px", 126.8616}, {"v_px", 45.60592}},
                 .source =
                     "python: 160 * 0.24 * (1 + p[1]) + 88.5, 162 * -0.16 * (1 + p[1]) + 71.5"},
                {.values = {0.002, -0.001},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
                 .expected = {{"u_px", 126.9}, {"v_px", 45.58}},
                 .source = "python: 160 * 0.24 + 88.5, 162 * -0.16 + 71.5"}},
  };
}

}  // namespace seam::effects
