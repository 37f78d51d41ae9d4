#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition viscous_friction() {
  return {
      .name = "viscous_friction",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {{.name = "per_s",
                      .min = 0,
                      .max = 1e4,
                      .scale = 1,
                      .help = "Deceleration for each rad/s, 1/s, whether or not the drive is on."}},
      .help = "Friction in proportion to the rate: bearings in grease.",
      .formula = "friction = per_s * w, in dw/dt of motor_servo",
      .signature = "swings die out by the same factor each time; slower at speed",
      .example = "viscous_friction: {per_s: 1.5}",
      .needs_base = Base::motor,
      .starts = {{kJoints, StartSearch::motion, {{1}}}},
      .advice = {{kJoints,
                  {"motor_servo"},
                  "free swings with torque_enable 0: back-EMF acts only while the drive is on, "
                  "viscous friction always"},
                 {kJoints,
                  {"coulomb_friction", "stribeck_friction"},
                  "free swings (torque_enable 0) until rest: viscous friction takes a share of "
                  "each swing, dry friction the same angle; slow ramps show dry friction alone"},
                 {kJoints, {}, "free swings with torque_enable 0"}},
      .servo = [](Values p, ServoModel& servo) { servo.torque.viscous_per_s = p[0]; },
      .proof = {{.values = {5},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.2}},
                 .expected = {{"joint_rad", 0.699976264762284}},
                 .source = "python: sprung(100, 10 + p[0], 1, at_s)"},
                {.values = {2},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.3}},
                 .expected = {{"joint_rad", 1.03815037677576}},
                 .source = "python: sprung(100, 10 + p[0], 1, at_s)"}},
  };
}

}  // namespace seam::effects
