#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition effort_scale() {
  return {
      .name = "effort_scale",
      .stage = Stage::joint,
      .kinds = kJoints,
      .parameters = {{.name = "scale",
                      .min = -0.95,
                      .max = 20,
                      .scale = 0.1,
                      .help = "By how large a share the log's torques are too large: a torque "
                              "constant that is wrong, or a gear's efficiency.",
                      .plausible = {-0.5, 2.5,
                                    "data sheets: constants within 10 %, of gears spur 70 to 95 % "
                                    "efficient, harmonic 50 to 85, worm 30 to 80"}}},
      .help = "The torque constant by which the log's torques were made of currents is wrong.",
      .formula = "effort_nm = (1 + scale) * effort",
      .signature = "measured torques in another proportion to the accelerations",
      .example = "effort_scale: {scale: 0.1}",
      .needs_base = Base::motor,
      .needs = {Need::motor_torques, Need::known_inertia},
      .starts = {{kJoints, StartSearch::listed, {{0.05}}}},
      .advice = {{kJoints,
                  {},
                  "a load of known inertia, or a known weight on a known arm, and joint_inertia "
                  "stated"}},
      .servo = [](Values p, ServoModel& servo) { servo.effort.scale += p[0]; },
      .proof =
          {{.values = {0.25},
            .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.1}, {"inertia_kg_m2", 0.02}},
            .expected = {{"effort_nm", 0.315482395692522}},
            .source = "python: (1 + p[0]) * inertia_kg_m2 * driven(100, 10, at_s)"},
           {.values = {-0.4},
            .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.02}, {"inertia_kg_m2", 0.3}},
            .expected = {{"effort_nm", 14.4228015543106}},
            .source = "python: (1 + p[0]) * inertia_kg_m2 * driven(100, 10, at_s)"}},
  };
}

}  // namespace seam::effects
