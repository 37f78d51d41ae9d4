#include "effects/effect.h"
#include "effects/stages/joint_track.h"

namespace seam::effects {

EffectDefinition encoder_offset() {
  return {
      .name = "encoder_offset",
      .stage = Stage::joint,
      .kinds = kPoints | kJoints | kRanges | kFrames,
      .parameters = {{.name = "tilt_rad",
                      .min = -0.5,
                      .max = 0.5,
                      .scale = 0.01,
                      .help = "True minus logged angle of the tilt joint, radians."},
                     {.name = "pan_rad",
                      .min = -0.5,
                      .max = 0.5,
                      .scale = 0.01,
                      .help = "True minus logged angle of the pan joint, radians."},
                     {.name = "roll_rad",
                      .min = -0.5,
                      .max = 0.5,
                      .scale = 0.01,
                      .help = "True minus logged angle of the roll joint, radians."}},
      .help = "The zero of a joint encoder is off.",
      .formula = "true = logged * (1 + scale) + offset",
      .signature = "constant displacement in the joint's direction",
      .example = "encoder_offset: {pan_rad: 0.02}",
      .encoder =
          [](Values p, JointTrack& track) {
            for (JointSeries& joint : track.joints) {
              if (joint.role == JointRole::other) continue;
              const double value = p[static_cast<int>(joint.role)];
              if (value == 0) continue;
              for (double& q : joint.q_rad) q += value;
            }
          },
      .logged =
          [](Values p, JointRole role, double q) {
            return role == JointRole::other ? q : q - p[static_cast<int>(role)];
          },
  };
}

}  // namespace seam::effects
