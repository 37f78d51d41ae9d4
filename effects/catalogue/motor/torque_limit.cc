#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition torque_limit() {
  return {
      .name = "torque_limit",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {{.name = "rad_per_s2",
                      .neutral = std::numeric_limits<double>::infinity(),
                      .min = 1e-2,
                      .max = 1e7,
                      .scale = 100,
                      .help =
                          "Largest angular acceleration by the drive, rad/s^2: a limit of current.",
                      .fit_reciprocal = true}},
      .help = "The drive gives no more than this, however large the duty.",
      .formula = "|drive| <= rad_per_s2, in dw/dt of motor_servo",
      .signature = "large steps are slower than small ones say, the same at two supplies",
      .example = "torque_limit: {rad_per_s2: 200}",
      .needs_base = Base::motor,
      .starts = {{kJoints, StartSearch::motion, {{30}, {100}, {300}, {1000}}}},
      .advice = {{kJoints,
                  {"motor_servo"},
                  "large steps at high gain with two supplies: the stall torque follows the "
                  "voltage, a limit of current does not"},
                 {kJoints, {}, "large steps at high gain"}},
      .servo = [](Values p, ServoModel& servo) { servo.torque.limit_rad_per_s2 = p[0]; },
      .proof = {{.values = {30},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.1}},
                 .expected = {{"joint_rad", 0.15}},
                 .source = "python: p[0] * at_s ** 2 / 2"},
                {.values = {40},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.25}},
                 .expected = {{"joint_rad", 0.898563800179973}},
                 .source = "python: swung(at_s, limit=p[0])",
                 .tolerance = 1e-07}},
  };
}

}  // namespace seam::effects
