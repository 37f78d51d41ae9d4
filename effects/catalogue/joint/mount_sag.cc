#include "effects/effect.h"
#include "effects/stages/joint_track.h"
#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

double bent(Values p, double q_rad) {
  return q_rad + p[0] * maths::cos(q_rad - p[1]);
}

}  // namespace

// A beam that carries a weight bends in proportion to its torque, the weight times the lever times
// the cosine of the elevation (of telescopes: tube flexure, the term TF of Wallace's TPoint).
// Plausible, for mounts of small cameras: 1e-4 to 2e-2 rad.
EffectDefinition mount_sag() {
  return {
      .name = "mount_sag",
      .stage = Stage::joint,
      .kinds = kPoints | kRanges | kFrames,
      .parameters = {{.name = "tilt_rad",
                      .min = -0.3,
                      .max = 0.3,
                      .scale = 5e-3,
                      .help = "How far the camera hangs where its load is level, radians, towards "
                              "larger angles of the tilt joint.",
                      .plausible = {-0.1, 0.1, "mounts of cameras bend by less than 2 degrees"}},
                     {.name = "tilt_level_rad",
                      .min = -maths::kPi,
                      .max = maths::kPi,
                      .scale = 0.3,
                      .help = "The angle at which the load is level, radians.",
                      .on_demand = true}},
      .help =
          "The mount, or the lens in it, bends under its own weight as the head tilts. The encoder "
          "sits before the bend and shows nothing of it.",
      .formula = "true = logged + tilt_rad cos(logged - tilt_level_rad)",
      .signature = "vertical displacement that depends on the tilt, most where the camera is level",
      .example = "mount_sag: {tilt_rad: 0.006}",
      .family = Family::pointing,
      .starts = {{kPoints, StartSearch::listed, {{1e-3, 0}, {-1e-3, 0}}}},
      .advice = {{kPoints,
                  {"encoder_offset", "mount_misalignment"},
                  "Tilt over the whole range: an offset is the same at each angle, a sag is least "
                  "where the camera looks straight up or down."},
                 {kPoints,
                  {"encoder_scale"},
                  "Tilt as far up as down: a scale changes its sign, a sag does not."},
                 {kPoints, {}, "the same points at tilts over the whole range of the joint"}},
      .encoder =
          [](Values p, JointTrack& track) {
            if (p[0] == 0) return;
            for (JointSeries& joint : track.joints) {
              if (joint.role != JointRole::tilt) continue;
              for (double& q : joint.q_rad) q = bent(p, q);
            }
          },
      .logged =
          [](Values p, JointRole role, double q) {
            if (role != JointRole::tilt || p[0] == 0) return q;
            // A contraction for every sag below 1.
            double logged = q;
            for (int step = 0; step < 24; ++step) logged = q - p[0] * maths::cos(logged - p[1]);
            return logged;
          },
      .proof =
          {{.values = {0.01, 0},
            .given = {{"logged_tilt_rad", 0.5}, {"logged_pan_rad", 0.5}, {"true_tilt_rad", -0.4}},
            .expected = {{"tilt_rad", 0.508775825618904},
                         {"pan_rad", 0.5},
                         {"logged_tilt_rad", -0.409174495640279}},
            .source = "python: 0.5 + p[0] * math.cos(0.5), 0.5, root(lambda q: q + p[0] * "
                      "math.cos(q) + 0.4, -1, 1)"},
           {.values = {-0.03, 0.7},
            .given = {{"logged_tilt_rad", -1}},
            .expected = {{"tilt_rad", -0.996134665171134}},
            .source = "python: -1 + p[0] * math.cos(-1 - p[1])"}},
  };
}

}  // namespace seam::effects
