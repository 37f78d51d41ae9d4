#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition joint_inertia() {
  return {
      .name = "joint_inertia",
      .stage = Stage::joint,
      .kinds = kJoints,
      .parameters = {{.name = "kg_m2",
                      .min = 0,
                      .max = 1e6,
                      .scale = 0.01,
                      .help = "Moment of inertia of joint and load about the joint's axis, kg m^2, "
                              "the motor's behind its gears included. 0: unknown.",
                      .required = true,
                      .stated = true}},
      .help =
          "What turns the motor's angular acceleration into torque. It moves nothing: a log's "
          "column effort_nm is the drive's torque. Without it the inertia is estimated from "
          "that column; stated, a wrong torque constant shows (effort_scale).",
      .formula = "effort = kg_m2 * drive of motor_servo",
      .signature = "measured torques in another proportion to the accelerations",
      .example = "joint_inertia: {kg_m2: 0.004}",
      .needs_base = Base::motor,
      .needs = {Need::motor_torques},
      .servo = [](Values p, ServoModel& servo) { servo.effort.inertia_kg_m2 = p[0]; },
      .proof = {{.values = {0.02},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.05}},
                 .expected = {{"effort_nm", 1.03649864614003}},
                 .source = "python: p[0] * driven(100, 10, at_s)"},
                {.values = {1.5},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.3}},
                 .expected = {{"effort_nm", -38.6396117139679}},
                 .source = "python: p[0] * driven(100, 10, at_s)"}},
  };
}

}  // namespace seam::effects
