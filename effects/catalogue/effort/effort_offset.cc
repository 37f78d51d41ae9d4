#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition effort_offset() {
  return {
      .name = "effort_offset",
      .stage = Stage::joint,
      .kinds = kJoints,
      .parameters = {{.name = "nm",
                      .min = -1e4,
                      .max = 1e4,
                      .scale = 0.1,
                      .help = "What the log shows where the motor gives no torque, N m: the zero "
                              "of a current sensor."}},
      .help = "The zero of the log's torques is off.",
      .formula = "effort_nm = effort + nm",
      .signature = "a constant in the measured torques, with the drive off, too",
      .example = "effort_offset: {nm: 0.02}",
      .needs_base = Base::motor,
      .needs = {Need::motor_torques},
      .starts = {{kJoints, StartSearch::listed, {{0.05}}}},
      .advice = {{kJoints, {}, "rows with torque_enable 0"}},
      .servo = [](Values p, ServoModel& servo) { servo.effort.offset_nm += p[0]; },
      .proof =
          {{.values = {0.05},
            .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.1}, {"inertia_kg_m2", 0.02}},
            .expected = {{"effort_nm", 0.302385916554017}},
            .source = "python: inertia_kg_m2 * driven(100, 10, at_s) + p[0]"},
           {.values = {-0.3},
            .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.2}},
            .expected = {{"effort_nm", -0.3}},
            .source = "python: p[0]"}},
  };
}

}  // namespace seam::effects
