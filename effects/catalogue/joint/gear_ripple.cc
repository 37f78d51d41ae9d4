#include "effects/stages/servo.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

// Error of transmission of gears: a wave at each tooth's mesh (teeth a turn), or at each turn of
// the motor (ratio a turn); of harmonic drives at twice the ratio (Tuttle and Seering, A nonlinear
// model of a harmonic drive gear transmission, IEEE Trans. Robotics and Automation 12, 1996: 0.001
// to 0.003 rad). Plausible: 1e-4 (harmonic) to 1e-2 rad (plastic gears), 2 to 200 a turn.
EffectDefinition gear_ripple() {
  return {
      .name = "gear_ripple",
      .stage = Stage::joint,
      .kinds = kJoints,
      .parameters =
          {{.name = "amplitude_rad",
            .min = 0,
            .max = 0.1,
            .scale = 1e-3,
            .help = "Amplitude of the wave, radians at the joint.",
            .plausible = {0, 0.03, "gears and encoders repeat within 0.01 to 1 degree"}},
           {.name = "per_turn",
            .neutral = 20,
            .min = 1.5,
            .max = 200,
            .scale = 1,
            .help = "Waves in one turn of the joint: its teeth, or the ratio of the gears."},
           {.name = "phase_rad", .min = -6.3, .max = 6.3, .scale = 1, .help = "Phase, radians."}},
      .help =
          "Gears turn the joint unevenly, in a wave over its angle: errors of teeth, or of the "
          "encoder's disc.",
      .formula = "q + A sin(per_turn q + phase)",
      .signature = "a wave over the joint's angle, the same in each run and at each speed",
      .example = "gear_ripple: {amplitude_rad: 0.002, per_turn: 40, phase_rad: 0.5}",
      .starts = {{kJoints, StartSearch::frequency}},
      .advice = {{kJoints,
                  {"encoder_eccentricity"},
                  "a turn of half a circle or more: a disc that is off its axis makes one wave a "
                  "turn, gears make many"},
                 {kJoints,
                  {"joint_wander"},
                  "the same way at two speeds: a wave of gears stays where it is over the angle, a "
                  "swing stays in time"},
                 {kJoints, {}, "slow ramps over the whole range, to and fro"}},
      .servo =
          [](Values p, ServoModel& servo) {
            servo.ripple = {.amplitude_rad = p[0], .per_turn = p[1], .phase_rad = p[2]};
          },
      .told_once = [](std::vector<double>& values) { values[2] = maths::wrap_angle(values[2]); },
      .proof = {{.values = {0.002, 40, 0.5},
                 .given = {{"command_s", 0},
                           {"command_rad", 0.5},
                           {"command_s", 0.1},
                           {"command_rad", 0.2},
                           {"at_s", 0.05}},
                 .expected = {{"joint_rad", 0.501993659588558}},
                 .source = "python: 0.5 + p[0] * math.sin(20.5)"},
                {.values = {0.01, 7.5, -1},
                 .given = {{"command_s", 0},
                           {"command_rad", 0.5},
                           {"command_s", 0.1},
                           {"command_rad", 0.2},
                           {"at_s", 0.2}},
                 .expected = {{"joint_rad", 0.204794255386042}},
                 .source = "python: 0.2 + p[0] * math.sin(0.5)"}},
  };
}

}  // namespace seam::effects
