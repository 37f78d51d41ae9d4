#include "effects/stages/servo.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

// Magnets pull on the iron's teeth: a torque in a wave over the motor's turn, with the current off,
// too. As many waves a turn as the least common multiple of slots and poles (Zhu and Howe,
// Influence of design parameters on cogging torque in permanent magnet machines, IEEE Trans. Energy
// Conversion 15, 2000), at least six.
EffectDefinition torque_cogging() {
  return {
      .name = "torque_cogging",
      .stage = Stage::joint,
      .kinds = kJoints,
      .parameters =
          {{.name = "rad_per_s2",
            .min = 0,
            .max = 1e5,
            .scale = 1,
            .help = "Amplitude of the wave of torque over the inertia, rad/s^2.",
            .plausible = {0, 5e3,
                          "drives of Beckhoff (AX8000, 32D3:03) balance up to half of a motor's "
                          "peak, a fifth by default; servos give at most 1e4 rad/s^2"}},
           {.name = "per_turn",
            .neutral = 12,
            .min = 4,
            .max = 200,
            .scale = 1,
            .help = "Waves in one turn of the joint: least common multiple of the motor's slots "
                    "and poles, times the ratio of its gears."},
           {.name = "phase_rad", .min = -6.3, .max = 6.3, .scale = 1, .help = "Phase, radians."}},
      .help =
          "The motor's magnets pull on its iron teeth: a torque in a wave over the angle, with the "
          "current off, too.",
      .formula = "dw/dt + rad_per_s2 sin(per_turn q + phase) in motor_servo; stands with the load",
      .signature =
          "rests in steps over the angle; runs unevenly, the more the slower it goes and the "
          "lower the gain",
      .example = "torque_cogging: {rad_per_s2: 8, per_turn: 12, phase_rad: 0.5}",
      .needs_base = Base::motor,
      .needs = {Need::moving_joint},
      .starts = {{kJoints, StartSearch::frequency}},
      .advice =
          {{kJoints,
            {"gear_ripple"},
            "slow ramps at two gains: what gears do to the angle stays, what a torque does is "
            "the less the higher the gain"},
           {kJoints,
            {"coulomb_friction", "stribeck_friction", "friction_asymmetry"},
            "slow ramps to and fro over the whole range, at a low gain: cogging pushes the "
            "same way at one angle in both directions"},
           {kJoints, {}, "slow ramps to and fro over the whole range, at a low gain"}},
      .servo =
          [](Values p, ServoModel& servo) {
            servo.torque.cogging_rad_per_s2 = p[0];
            servo.torque.cogging_per_turn = p[1];
            servo.torque.cogging_rad = p[2];
          },
      .told_once = [](std::vector<double>& values) { values[2] = maths::wrap_angle(values[2]); },
      .proof = {{.values = {20, 12, 0.5},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.2}},
                 .expected = {{"joint_rad", 0.885878887583936}},
                 .source = "python: swung(at_s, cogging=p[0], waves=p[1], phase=p[2])",
                 .tolerance = 1e-07},
                {.values = {35, 7.5, -1},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.12}},
                 .expected = {{"joint_rad", 0.398102168819618}},
                 .source = "python: swung(at_s, cogging=p[0], waves=p[1], phase=p[2])",
                 .tolerance = 1e-07}},
  };
}

}  // namespace seam::effects
