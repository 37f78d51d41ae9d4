#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition stiction() {
  return {
      .name = "stiction",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {{.name = "dead_band_rad",
                      .min = 0,
                      .max = 1,
                      .scale = 0.01,
                      .help =
                          "The joint rests while it is nearer to its command than this, radians.",
                      .plausible = {0, 0.1, "servos of models rest within 0.3 to 3 degrees"}}},
      .help = "Static friction: a command that is too near does not move the joint.",
      .formula = "no motion while |command - q| < band",
      .signature = "steady error after small moves",
      .example = "stiction: {dead_band_rad: 0.01}",
      .term = Term::kinematic,
      .shows_at_rest = true,
      .servo = [](Values p, ServoModel& servo) { servo.dead_band_rad += p[0]; },
      .proof = {{.values = {0.02},
                 .given = {{"command_s", 0}, {"command_rad", 0.015}, {"at_s", 1}},
                 .expected = {{"joint_rad", 0}},
                 .source = "python: 0"},
                {.values = {0.02},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"limit_radps", 2}, {"at_s", 1}},
                 .expected = {{"joint_rad", 0.98}},
                 .source = "python: 1 - p[0]"},
                {.values = {0.02},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"limit_radps", 2}, {"at_s", 0.3}},
                 .expected = {{"joint_rad", 0.6}},
                 .source = "python: 2 * at_s"}},
  };
}

}  // namespace seam::effects
