#include "effects/stages/servo.h"

namespace seam::effects {

// At a fixed voltage current and back-EMF's braking fall as the windings' resistance grows: 0.0039
// of its value at 20 C for each kelvin in copper (IEC 60228), 0.0036 about 40 C. Magnets lose 0.001
// (NdFeB) to 0.002 (ferrite) of their flux for each kelvin besides. Plausible: 0.003 to 0.006.
EffectDefinition motor_heating() {
  return {
      .name = "motor_heating",
      .stage = Stage::joint,
      .kinds = kJoints,
      .parameters = {{.name = "per_k",
                      .min = -0.02,
                      .max = 0.05,
                      .scale = 0.004,
                      .help = "Growth of the windings' resistance for each kelvin above the median "
                              "of the column temperature_c, as a share. Copper: 0.0036.",
                      .plausible = {-0.001, 0.01,
                                    "copper 0.0039, weaker magnets another 0.001 to 0.002"}}},
      .help =
          "A warm motor is weaker: its windings resist more and its magnets hold less. The log "
          "says how warm in a column temperature_c.",
      .formula = "drive / (1 + per_k (temperature_c - median)) in motor_servo, before its limit",
      .signature = "slower, and farther from its command under load, the warmer the motor",
      .example = "motor_heating: {per_k: 0.004}",
      .columns = {"temperature_c"},
      .needs_base = Base::motor,
      .starts = {{kJoints, StartSearch::motion, {{0.004}}}},
      .advice =
          {{kJoints,
            {},
            "the same moves cold and after half an hour of work, with the temperature logged"}},
      .servo = [](Values p, ServoModel& servo) { servo.torque.weakening_per_k += p[0]; },
      .proof = {{.values = {0.005},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"warmer_k", 20}, {"at_s", 0.2}},
                 .expected = {{"joint_rad", 0.825136437005215}},
                 .source = "python: sprung(100 / 1.1, 10 / 1.1, 1, at_s)"},
                {.values = {0.01},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"warmer_k", -30}, {"at_s", 0.1}},
                 .expected = {{"joint_rad", 0.420006830235945}},
                 .source = "python: sprung(100 / 0.7, 10 / 0.7, 1, at_s)"}},
  };
}

}  // namespace seam::effects
