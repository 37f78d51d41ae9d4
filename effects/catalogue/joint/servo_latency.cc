#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition servo_latency() {
  return {
      .name = "servo_latency",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {{.name = "latency_s",
                      .min = 0,
                      .max = 2,
                      .scale = 0.01,
                      .help = "Time between a command and its action, seconds.",
                      .plausible = {0, 0.5, "buses and controllers take 1 to 100 ms"}}},
      .help = "Commands act later by a constant: communication, buffers, the servo's own cycle.",
      .formula = "the command acts this much later",
      .signature = "error in proportion to the rate of the command, without rounding of steps",
      .example = "servo_latency: {latency_s: 0.016}",
      .servo = [](Values p, ServoModel& servo) { servo.latency_s += p[0]; },
      .proof = {{.values = {0.016},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.015}},
                 .expected = {{"joint_rad", 0}},
                 .source = "python: 0"},
                {.values = {0.016},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.017}},
                 .expected = {{"joint_rad", 1}},
                 .source = "python: 1"}},
  };
}

}  // namespace seam::effects
