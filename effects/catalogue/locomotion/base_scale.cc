#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

EffectDefinition base_scale() {
  return {
      .name = "base_scale",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {{.name = "scale",
                      .min = -0.5,
                      .max = 1,
                      .scale = 0.01,
                      .help = "Relative error of the distance between the wheels; positive: they "
                              "stand wider, and the body turns less.",
                      .plausible = {-0.3, 0.5,
                                    "wide tyres turn about a point within their width; tracks up "
                                    "to 1.5 times their base"}}},
      .help = "The wheels touch the ground farther apart or nearer than they are taken for.",
      .formula = "base_m (1 + scale)",
      .signature = "error of the heading in proportion to the turn",
      .example = "base_scale: {scale: 0.02}",
      .needs = {Need::wheels, Need::turning},
      .advice = {{kOdometry, {}, "turns on the spot by many circles, both ways round"}},
      .locomotion = [](Values p, Locomotion& walk) { walk.wheels.base_scale += p[0]; },
      .proof = {{.values = {0.25},
                 .given = {{"left_ticks", -100}, {"right_ticks", 100}, {"for_s", 1}},
                 .expected = {{"x_m", 0}, {"theta_rad", 0.8}},
                 .source = "python: 0, 200 * 0.001 / (0.2 * 1.25)"},
                {.values = {-0.2},
                 .given = {{"omega_radps", 0.4}, {"for_s", 2}},
                 .expected = {{"theta_rad", 1}},
                 .source = "python: 0.8 / (1 + p[0])"}},
  };
}

}  // namespace seam::effects
