#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

EffectDefinition wheel_scale() {
  const auto wheel = [](const char* side) {
    return Parameter{.name = side,
                     .min = -0.5,
                     .max = 1,
                     .scale = 0.01,
                     .help = std::string("Relative error of the ") + side +
                             " wheel's size; positive: it rolls farther than its ticks say.",
                     .plausible = {-0.2, 0.2, "tyres wear and give by 1 to 5 %"}};
  };
  return {
      .name = "wheel_scale",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {wheel("left"), wheel("right")},
      .help =
          "The wheels are larger or smaller than they are taken for, each by itself: the body "
          "drives too far, and curves where it should go straight.",
      .formula = "left (1 + left), right (1 + right)",
      .signature = "distance error in proportion to distance, and a turn with distance",
      .example = "wheel_scale: {left: 0.01, right: -0.005}",
      .needs = {Need::wheels, Need::path},
      .advice = {{kOdometry,
                  {"base_scale", "wheel_slip"},
                  "Drive squares both ways round, with long sides: unequal wheels turn the sides, "
                  "a wrong base turns the corners."},
                 {kOdometry, {}, "long straight drives, and squares driven both ways round"}},
      .locomotion =
          [](Values p, Locomotion& walk) {
            walk.wheels.left_scale += p[0];
            walk.wheels.right_scale += p[1];
          },
      .proof = {{.values = {0.1, -0.1},
                 .given = {{"left_ticks", 500}, {"right_ticks", 500}, {"for_s", 4}},
                 .expected = {{"x_m", 0.479425538604203},
                              {"y_m", -0.122417438109627},
                              {"theta_rad", -0.5}},
                 .source = "python: math.sin(0.5), math.cos(0.5) - 1, (0.45 - 0.55) / 0.2"},
                {.values = {0.02, 0.02},
                 .given = {{"vx_mps", 0.3}, {"for_s", 2}},
                 .expected = {{"x_m", 0.612}, {"theta_rad", 0}},
                 .source = "python: 0.6 * (1 + p[0]), 0"}},
  };
}

}  // namespace seam::effects
