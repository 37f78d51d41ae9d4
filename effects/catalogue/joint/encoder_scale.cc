#include "effects/effect.h"
#include "effects/stages/head_joints.h"

namespace seam::effects {

EffectDefinition encoder_scale() {
  return {
      .name = "encoder_scale",
      .stage = Stage::joint,
      .kinds = kPoints | kJoints | kRanges | kFrames,
      .parameters = head_joint_parameters("_scale", "Relative error of the ", " encoder."),
      .help = "The encoder reports too small or too large angles in proportion.",
      .formula = "true = logged * (1 + scale) + offset",
      .signature = "displacement grows with the joint angle",
      .example = "encoder_scale: {pan_scale: -0.02}",
      .family = Family::pointing,
      .advice = {{kPoints,
                  {"focal_length_error"},
                  "See the same points at several head angles, up to both ends of the joint."}},
      .encoder =
          [](Values p, JointTrack& track) {
            change_head_angles(p, track, [](double& q, double value) { q *= 1 + value; });
          },
      .logged =
          [](Values p, JointRole role, double q) {
            return role == JointRole::other ? q : q / (1 + p[static_cast<int>(role)]);
          },
      .proof = {{.values = {0.1, -0.02, 0.05},
                 .given = {{"logged_tilt_rad", 0.5},
                           {"logged_pan_rad", 1},
                           {"logged_roll_rad", -0.4},
                           {"true_pan_rad", 0.49}},
                 .expected = {{"tilt_rad", 0.55},
                              {"pan_rad", 0.98},
                              {"roll_rad", -0.42},
                              {"logged_pan_rad", 0.5}},
                 .source =
                     "python: 0.5 * (1 + p[0]), 1 + p[1], -0.4 * (1 + p[2]), 0.49 / (1 + p[1])"},
                {.values = {0, 0.2, 0},
                 .given = {{"logged_pan_rad", -0.3}},
                 .expected = {{"pan_rad", -0.36}},
                 .source = "python: -0.3 * (1 + p[1])"}},
  };
}

}  // namespace seam::effects
