#include "effects/effect.h"
#include "effects/stages/head_joints.h"

namespace seam::effects {

EffectDefinition encoder_offset() {
  return {
      .name = "encoder_offset",
      .stage = Stage::joint,
      .kinds = kPoints | kJoints | kRanges | kFrames,
      .parameters =
          head_joint_parameters("_rad", "True minus logged angle of the ", " joint, radians."),
      .help = "The zero of a joint encoder is off.",
      .formula = "true = logged * (1 + scale) + offset",
      .signature = "constant displacement in the joint's direction",
      .example = "encoder_offset: {pan_rad: 0.02}",
      .family = Family::pointing,
      .advice = {{kPoints,
                  {"principal_point_offset"},
                  "Tilt the head far while panning, and bring points near: an offset of a joint "
                  "turns with the chain."},
                 {kPoints,
                  {"mount_misalignment"},
                  "Tilt the head over its whole range: a mount turns with the last link."},
                 {kPoints,
                  {"mount_offset"},
                  "Bring points near to the camera: a shift shows in proportion to 1 / distance."}},
      .encoder =
          [](Values p, JointTrack& track) {
            change_head_angles(p, track, [](double& q, double value) { q += value; });
          },
      .logged =
          [](Values p, JointRole role, double q) {
            return role == JointRole::other ? q : q - p[static_cast<int>(role)];
          },
      .proof = {{.values = {0.01, 0.02, -0.03},
                 .given = {{"logged_tilt_rad", 0.5},
                           {"logged_pan_rad", 1},
                           {"logged_roll_rad", -0.4},
                           {"true_roll_rad", 0.2}},
                 .expected = {{"tilt_rad", 0.51},
                              {"pan_rad", 1.02},
                              {"roll_rad", -0.43},
                              {"logged_roll_rad", 0.23}},
                 .source = "python: 0.5 + p[0], 1 + p[1], -0.4 + p[2], 0.2 - p[2]"},
                {.values = {0, -0.1, 0},
                 .given = {{"logged_pan_rad", 0.25}},
                 .expected = {{"pan_rad", 0.15}},
                 .source = "python: 0.25 + p[1]"}},
  };
}

}  // namespace seam::effects
