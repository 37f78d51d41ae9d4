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
                      .help =
                          "Time constant, seconds: after a step 63 % of the way is made in it."}},
      .help =
          "The joint approaches its command at a rate in proportion to the distance, as under "
          "a position controller of finite gain.",
      .formula = "dq/dt = (command - q) / tau",
      .signature = "error in proportion to the rate of the command; steps are rounded",
      .example = "servo_lag: {tau_s: 0.04}",
      .servo = [](Values p, ServoModel& servo) { servo.tau_s += p[0]; },
  };
}

}  // namespace seam::effects
