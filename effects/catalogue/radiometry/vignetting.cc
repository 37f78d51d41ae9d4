#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition vignetting() {
  return {
      .name = "vignetting",
      .stage = Stage::radiometry,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "a2",
                      .min = -1,
                      .max = 1,
                      .scale = 0.1,
                      .help = "Loss with the square of rho, relative.",
                      .plausible = {-0.2, 1,
                                    "light falls outwards: at 45 degrees to a quarter by cos^4"}},
                     {.name = "a4",
                      .min = -1,
                      .max = 1,
                      .scale = 0.1,
                      .help = "Loss with the fourth power of rho, relative."}},
      .help = "The lens gives less light away from the centre (limb darkening).",
      .formula = "gain = 1 - a2 rho^2 - a4 rho^4",
      .signature = "mean falls with radius, in proportion to intensity",
      .example = "vignetting: {a2: 0.28, a4: 0.05}",
      .family = Family::brightness,
      .gain =
          [](Values p, const ImagePoint& point) {
            const double r = rho(point.u, point.v, point.width_px, point.height_px);
            return 1 - p[0] * r * r - p[1] * r * r * r * r;
          },
      .proof = {{.values = {0.28, 0.05},
                 .given = {{"u_px", 20}, {"v_px", 130}},
                 .expected = {{"gain", 0.807456594529467}},
                 .source = "python: 1 - p[0] * (68.5**2 + 58.5**2) / (89**2 + 72**2) - p[1] * "
                           "((68.5**2 + 58.5**2) / (89**2 + 72**2))**2"},
                {.values = {0, 0.1},
                 .given = {{"u_px", 88.5}, {"v_px", 0}},
                 .expected = {{"gain", 0.984782261511191}},
                 .source = "python: 1 - p[1] * (71.5**2 / (89**2 + 72**2))**2"}},
  };
}

}  // namespace seam::effects
