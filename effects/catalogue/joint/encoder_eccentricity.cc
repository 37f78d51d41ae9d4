#include "effects/effect.h"
#include "effects/stages/joint_track.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

EffectDefinition encoder_eccentricity() {
  return {
      .name = "encoder_eccentricity",
      .stage = Stage::joint,
      .kinds = kPoints | kJoints | kRanges | kFrames,
      .parameters = {{.name = "amplitude_rad",
                      .min = 0,
                      .max = 0.3,
                      .scale = 0.01,
                      .help = "Amplitude of the wave, radians.",
                      .needs = {Need::pan_turn},
                      .plausible = {0, 0.1, "a disc off its axis by a tenth of its radius"}},
                     {.name = "phase_rad",
                      .min = -6.3,
                      .max = 6.3,
                      .scale = 1,
                      .help = "Phase of the wave, radians.",
                      .needs = {Need::pan_turn}}},
      .help = "The encoder's disc of the pan joint is not centred on its axis.",
      .formula = "true = logged + A sin(true + phase)",
      .signature = "one wave over a turn",
      .example = "encoder_eccentricity: {amplitude_rad: 0.01, phase_rad: 0.4}",
      .starts =
          {{kPoints,
            StartSearch::listed,
            {{0.005, -2.4}, {0.005, -2.4 + 1.6}, {0.005, -2.4 + 1.6 * 2}, {0.005, -2.4 + 1.6 * 3}}},
           {kJoints, StartSearch::wave}},
      .encoder =
          [](Values p, JointTrack& track) {
            if (p[0] == 0) return;
            for (JointSeries& joint : track.joints) {
              if (joint.role != JointRole::pan) continue;
              // A contraction for every amplitude below 1.
              for (double& q : joint.q_rad) {
                const double logged = q;
                for (int step = 0; step < 12; ++step) q = logged + p[0] * maths::sin(q + p[1]);
              }
            }
          },
      .logged =
          [](Values p, JointRole role, double q) {
            return role == JointRole::pan ? q - p[0] * maths::sin(q + p[1]) : q;
          },
      .proof =
          {{.values = {0.01, 0.4},
            .given = {{"logged_pan_rad", 0.7}, {"logged_tilt_rad", 0.7}, {"true_pan_rad", 1.1}},
            .expected = {{"pan_rad", 0.708952323326955},
                         {"tilt_rad", 0.7},
                         {"logged_pan_rad", 1.09002505013396}},
            .source = "python: root(lambda q: q - 0.7 - p[0] * math.sin(q + p[1]), 0, 2), 0.7, 1.1 "
                      "- p[0] * math.sin(1.1 + p[1])"},
           {.values = {0.1, -1},
            .given = {{"logged_pan_rad", -0.5}},
            .expected = {{"pan_rad", -0.599957484357455}},
            .source = "python: root(lambda q: q + 0.5 - p[0] * math.sin(q + p[1]), -2, 2)"}},
  };
}

}  // namespace seam::effects
