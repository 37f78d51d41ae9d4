#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition uneven_lighting() {
  return {
      .name = "uneven_lighting",
      .stage = Stage::light,
      .kinds = kPhotometry,
      .parameters = {{.name = "gx",
                      .min = -1,
                      .max = 1,
                      .scale = 0.05,
                      .help = "Change of the light from the left edge to the right, relative."},
                     {.name = "gy",
                      .min = -1,
                      .max = 1,
                      .scale = 0.05,
                      .help = "Change of the light from the top edge to the bottom, relative."}},
      .help = "A flat field whose light grows linearly over the image.",
      .formula = "gain = 1 + gx (u/(W-1) - 1/2) + gy (v/(H-1) - 1/2)",
      .signature = "a plane in the mean",
      .example = "uneven_lighting: {gx: 0.1, gy: -0.05}",
      .gain =
          [](Values p, const ImagePoint& point) {
            const auto centred = [](double x, int n) { return n > 1 ? x / (n - 1) - 0.5 : 0.0; };
            return 1 + p[0] * centred(point.u, point.width_px) +
                   p[1] * centred(point.v, point.height_px);
          },
      .proof = {{.values = {0.1, -0.05},
                 .given = {{"u_px", 0}, {"v_px", 143}},
                 .expected = {{"gain", 0.925}},
                 .source = "python: 1 - p[0] / 2 + p[1] / 2"},
                {.values = {0.2, 0.4},
                 .given = {{"u_px", 132.75}, {"v_px", 71.5}},
                 .expected = {{"gain", 1.05}},
                 .source = "python: 1 + p[0] / 4"}},
  };
}

}  // namespace seam::effects
