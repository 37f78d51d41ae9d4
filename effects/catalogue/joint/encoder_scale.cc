#include "effects/effect.h"
#include "effects/stages/joint_track.h"

namespace seam::effects {

EffectDefinition encoder_scale() {
  return {
      .name = "encoder_scale",
      .stage = Stage::joint,
      .kinds = kPoints | kJoints | kRanges | kFrames,
      .parameters = {{.name = "tilt_scale",
                      .min = -0.5,
                      .max = 0.5,
                      .scale = 0.01,
                      .help = "Relative error of the tilt encoder."},
                     {.name = "pan_scale",
                      .min = -0.5,
                      .max = 0.5,
                      .scale = 0.01,
                      .help = "Relative error of the pan encoder."},
                     {.name = "roll_scale",
                      .min = -0.5,
                      .max = 0.5,
                      .scale = 0.01,
                      .help = "Relative error of the roll encoder."}},
      .help = "The encoder reports too small or too large angles in proportion.",
      .formula = "true = logged * (1 + scale) + offset",
      .signature = "displacement grows with the joint angle",
      .example = "encoder_scale: {pan_scale: -0.02}",
      .encoder =
          [](Values p, JointTrack& track) {
            for (JointSeries& joint : track.joints) {
              if (joint.role == JointRole::other) continue;
              const double value = p[static_cast<int>(joint.role)];
              if (value == 0) continue;
              for (double& q : joint.q_rad) q *= 1 + value;
            }
          },
      .logged =
          [](Values p, JointRole role, double q) {
            return role == JointRole::other ? q : q / (1 + p[static_cast<int>(role)]);
          },
  };
}

}  // namespace seam::effects
