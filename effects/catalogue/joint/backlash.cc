#include "effects/effect.h"
#include "effects/stages/joint_track.h"
#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition backlash() {
  return {
      .name = "backlash",
      .stage = Stage::joint,
      .kinds = kPoints | kJoints | kRanges | kFrames,
      .parameters = {{.name = "width_rad",
                      .min = 0,
                      .max = 0.3,
                      .scale = 0.01,
                      .help = "Play of the pan joint, or of the logged joint, radians."},
                     {.name = "tilt_width_rad",
                      .min = 0,
                      .max = 0.3,
                      .scale = 0.01,
                      .help = "Play of the tilt joint, radians."},
                     {.name = "roll_width_rad",
                      .min = 0,
                      .max = 0.3,
                      .scale = 0.01,
                      .help = "Play of the roll joint, radians."}},
      .help = "Play between motor and load: the load trails the motor by half the width.",
      .formula = "the play operator of this width, starting centred",
      .signature = "sign of the joint's rate",
      .example = "backlash: {width_rad: 0.01}",
      .encoder =
          [](Values p, JointTrack& track) {
            for (JointSeries& joint : track.joints) {
              if (joint.role == JointRole::pan) apply_play(p[0], joint.q_rad);
              if (joint.role == JointRole::tilt) apply_play(p[1], joint.q_rad);
              if (joint.role == JointRole::roll) apply_play(p[2], joint.q_rad);
            }
          },
      .servo = [](Values p, ServoModel& servo) { servo.backlash_rad += p[0]; },
  };
}

}  // namespace seam::effects
