#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition chromatic_aberration() {
  return {
      .name = "chromatic_aberration",
      .stage = Stage::geometry,
      .kinds = kPoints | kFrames | kRanges,
      .parameters = {{.name = "red_scale",
                      .min = -0.1,
                      .max = 0.1,
                      .scale = 0.001,
                      .help = "Radius of red against green, relative."},
                     {.name = "blue_scale",
                      .min = -0.1,
                      .max = 0.1,
                      .scale = 0.001,
                      .help = "Radius of blue against green, relative."}},
      .help = "The lens magnifies the colours differently.",
      .formula = "red: (x, y) * (1 + red_scale), blue: (x, y) * (1 + blue_scale)",
      .signature = "colour fringes that grow outwards",
      .example = "chromatic_aberration: {red_scale: 0.002, blue_scale: -0.001}",
      .geometry =
          [](Values p, ImagePoint& point) {
            if (point.channel == 1) return;
            const double scale = 1 + (point.channel == 0 ? p[0] : p[1]);
            point.xd *= scale;
            point.yd *= scale;
          },
  };
}

}  // namespace seam::effects
