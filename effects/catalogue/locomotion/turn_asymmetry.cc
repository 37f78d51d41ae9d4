#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

EffectDefinition turn_asymmetry() {
  return {
      .name = "turn_asymmetry",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {{.name = "left_excess",
                      .min = -1,
                      .max = 1,
                      .scale = 0.02,
                      .help =
                          "Share by which turns to the left are longer than those to the right; "
                          "negative: shorter.",
                      .plausible = {-0.5, 0.5,
                                    "left and right turns of legs differ by up to 30 %"}}},
      .help =
          "Turns to the left are longer than those to the right, which are as commanded: one wheel "
          "grips less, or the legs push unevenly. What is wrong with both is odometry_scale: where "
          "right turns alone are wrong by a share s, omega_scale is s and left_excess is -s.",
      .formula = "omega (1 + left_excess) in turns to the left, omega in those to the right",
      .signature = "heading error with the amount of turning to the left alone",
      .example = "turn_asymmetry: {left_excess: 0.025}",
      .needs = {Need::commanded_walk, Need::both_turns},
      .advice = {{kOdometry,
                  {},
                  "Turn on the spot, several times round to the left, then as often to the right: "
                  "only unlike turns leave the body turned at the end, since it covers no path."}},
      .locomotion = [](Values p, Locomotion& walk) { walk.left_excess += p[0]; },
      .proof =
          {{.values = {0.025},
            .given = {{"omega_radps", 0.8}, {"for_s", 2}, {"omega_radps", -0.8}, {"for_s", 3}},
            .expected = {{"theta_rad", -0.76}},
            .source = "python: 1.6 * (1 + p[0]) - 2.4"},
           {.values = {-0.1},
            .given = {{"vx_mps", 0.3}, {"omega_radps", 0.5}, {"for_s", 2}},
            .expected = {{"x_m", 0.522217939751656}, {"y_m", 0.25226002115289}, {"theta_rad", 0.9}},
            .source = "python: 0.3 / 0.45 * math.sin(0.9), 0.3 / 0.45 * (1 - math.cos(0.9)), 0.9"}},
  };
}

}  // namespace seam::effects
