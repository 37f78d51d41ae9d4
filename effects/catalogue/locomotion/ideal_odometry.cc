#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

EffectDefinition ideal_odometry() {
  return {
      .name = "ideal_odometry",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {},
      .help = "The body moves as commanded: the base to which locomotion effects are added.",
      .formula = "the body moves as commanded",
      .signature = "none: it is the base of walk models",
      .example = "ideal_odometry: {}",
      .has_neutral = false,
      .base = Base::walk,
      .locomotion = [](Values, Locomotion&) {},
      .proof =
          {{.values = {},
            .given = {{"vx_mps", 0.2}, {"for_s", 3}},
            .expected = {{"x_m", 0.6}, {"y_m", 0}, {"theta_rad", 0}},
            .source = "python: 0.2 * 3, 0"},
           {.values = {},
            .given = {{"vx_mps", 0.2}, {"vy_mps", -0.1}, {"omega_radps", 0.5}, {"for_s", 2}},
            .expected = {{"x_m", 0.428527932749428}, {"y_m", 0.0155848806917835}, {"theta_rad", 1}},
            .source = "python: walked(p, [((0.2, -0.1, 0.5), 2)])[0], walked(p, [((0.2, -0.1, "
                      "0.5), 2)])[1], 1"}},
  };
}

}  // namespace seam::effects
