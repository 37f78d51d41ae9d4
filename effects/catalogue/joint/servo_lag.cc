#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition servo_lag() {
  return {
      .name = "servo_lag",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {{.name = "tau_s",
                      .min = 0,
                      .max = 5,
                      .scale = 0.03,
                      .help = "Time constant, seconds: after a step 63 % of the way is made in it.",
                      .plausible = {0, 1, "servos settle in 20 to 500 ms"}}},
      .help =
          "The joint approaches its command at a rate in proportion to the distance, as under "
          "a position controller of finite gain.",
      .formula = "dq/dt = (command - q) / tau",
      .signature = "error in proportion to the rate of the command; steps are rounded",
      .example = "servo_lag: {tau_s: 0.04}",
      .term = Term::kinematic,
      .advice = {{kJoints,
                  {"servo_latency"},
                  "steps of the command, sampled several times within the delay: a lag rounds "
                  "them, a latency moves them"},
                 {kJoints,
                  {"speed_limit"},
                  "steps of different heights: a lag takes the same time for each"}},
      .servo = [](Values p, ServoModel& servo) { servo.tau_s += p[0]; },
      .proof = {{.values = {0.04},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.06}},
                 .expected = {{"joint_rad", 0.77686983985157}},
                 .source = "python: 1 - math.exp(-at_s / p[0])"},
                {.values = {0.1},
                 .given = {{"command_s", 0},
                           {"command_rad", 0.5},
                           {"command_s", 0.1},
                           {"command_rad", 0.2},
                           {"at_s", 0.3}},
                 .expected = {{"joint_rad", 0.215707050787052}},
                 .source =
                     "python: 0.2 + (0.5 * (1 - math.exp(-1)) - 0.2) * math.exp(-0.2 / p[0])"}},
  };
}

}  // namespace seam::effects
