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
                      .help = "Share by which turns to the left are longer than commanded, and "
                              "those to the right shorter.",
                      .plausible = {-0.5, 0.5,
                                    "left and right turns of legs differ by up to 30 %"}}},
      .help =
          "Turns to the left and to the right are unlike: one wheel grips less, or the legs push "
          "unevenly. What both have in common is the scale of turns.",
      .formula = "omega + left_excess |omega|",
      .signature = "heading error with the amount of turning, the same way in left and right turns",
      .example = "turn_asymmetry: {left_excess: 0.025}",
      .needs = {Need::commanded_walk, Need::both_turns},
      .advice = {{kOdometry,
                  {},
                  "Turn on the spot, several times round to the left, then as often to the right: "
                  "only unlike turns leave the body turned at the end, since it covers no path."}},
      .locomotion = [](Values p, Locomotion& walk) { walk.turn_asymmetry += p[0]; },
      .proof =
          {{.values = {0.025},
            .given = {{"omega_radps", 0.8}, {"for_s", 2}, {"omega_radps", -0.8}, {"for_s", 3}},
            .expected = {{"theta_rad", -0.7}},
            .source = "python: 1.6 * (1 + p[0]) - 2.4 * (1 - p[0])"},
           {.values = {-0.1},
            .given = {{"vx_mps", 0.3}, {"omega_radps", -0.5}, {"for_s", 2}},
            .expected = {{"x_m", 0.486113105488056},
                         {"y_m", -0.298038479222412},
                         {"theta_rad", -1.1}},
            .source =
                "python: 0.3 / 0.55 * math.sin(1.1), -0.3 / 0.55 * (1 - math.cos(1.1)), -1.1"}},
  };
}

}  // namespace seam::effects
