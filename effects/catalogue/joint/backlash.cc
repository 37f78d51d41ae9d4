#include "effects/effect.h"
#include "effects/stages/joint_track.h"
#include "effects/stages/servo.h"

namespace seam::effects {
namespace {

std::vector<Proof> backlash_proof() {
  return {{.values = {0.01, 0.02, 0},
           .given = {{"logged_pan_rad", 0},
                     {"logged_pan_rad", 0.1},
                     {"logged_pan_rad", 0.098},
                     {"logged_tilt_rad", 0},
                     {"logged_tilt_rad", 0.1},
                     {"logged_tilt_rad", 0.05}},
           .expected = {{"pan_rad", 0.095}, {"tilt_rad", 0.06}},
           .source = "python: play(p[0], 0, 0.1, 0.098), play(p[1], 0, 0.1, 0.05)"},
          {.values = {0, 0, 0.03},
           .given = {{"logged_roll_rad", 0.3}, {"logged_roll_rad", -0.2}},
           .expected = {{"roll_rad", -0.185}},
           .source = "python: -0.2 + p[2] / 2"},
          {.values = {0.02, 0, 0},
           .given = {{"command_s", 0},
                     {"command_rad", 0.5},
                     {"command_s", 0.1},
                     {"command_rad", 0.2},
                     {"at_s", 0.2}},
           .expected = {{"joint_rad", 0.21}},
           .source = "python: play(p[0], 0, 0.5, 0.2)"}};
}

}  // namespace

EffectDefinition backlash() {
  return {
      .name = "backlash",
      .stage = Stage::joint,
      .kinds = kPoints | kJoints | kRanges | kFrames,
      .parameters =
          {{.name = "width_rad",
            .min = 0,
            .max = 0.3,
            .scale = 0.01,
            .help = "Play of the pan joint, or of the logged joint, radians.",
            .needs = {Need::pan_reversals},
            .plausible = {0, 0.1,
                          "gears of servos have 0.1 to 2 degrees of play, worn ones up to 5"}},
           {.name = "tilt_width_rad",
            .min = 0,
            .max = 0.3,
            .scale = 0.01,
            .help = "Play of the tilt joint, radians.",
            .needs = {Need::tilt_reversals},
            .plausible = {0, 0.1, "as of the pan joint"}},
           {.name = "roll_width_rad",
            .min = 0,
            .max = 0.3,
            .scale = 0.01,
            .help = "Play of the roll joint, radians.",
            .needs = {Need::roll_reversals},
            .plausible = {0, 0.1, "as of the pan joint"}}},
      .help = "Play between motor and load: the load trails the motor by half the width.",
      .formula = "the play operator of this width, starting centred",
      .signature = "sign of the joint's rate",
      .example = "backlash: {width_rad: 0.01}",
      .family = Family::pointing,
      .remembers = true,
      .shows_at_rest = true,
      .advice = {{kJoints,
                  {"stiction"},
                  "small moves in one direction, one after the other: play is taken up once, a "
                  "dead band stops each of them"}},
      .encoder =
          [](Values p, JointTrack& track) {
            for (JointSeries& joint : track.joints) {
              if (joint.role == JointRole::pan) apply_play(p[0], joint.q_rad);
              if (joint.role == JointRole::tilt) apply_play(p[1], joint.q_rad);
              if (joint.role == JointRole::roll) apply_play(p[2], joint.q_rad);
            }
          },
      .servo = [](Values p, ServoModel& servo) { servo.backlash_rad += p[0]; },
      .play_rad =
          [](Values p, JointRole role) {
            return role == JointRole::pan    ? p[0]
                   : role == JointRole::tilt ? p[1]
                   : role == JointRole::roll ? p[2]
                                             : 0;
          },
      .proof = backlash_proof(),
  };
}

}  // namespace seam::effects
