#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition mount_misalignment() {
  return {
      .name = "mount_misalignment",
      .stage = Stage::mount,
      .kinds = kPoints | kLandmarks | kRanges | kFrames,
      .parameters = {{.name = "roll_rad",
                      .min = -1,
                      .max = 1,
                      .scale = 0.02,
                      .help = "About the optical axis, radians.",
                      .needs = {Need::space}},
                     {.name = "pitch_rad",
                      .min = -1,
                      .max = 1,
                      .scale = 0.02,
                      .help = "Positive looks down, radians.",
                      .needs = {Need::space}},
                     {.name = "yaw_rad",
                      .min = -3.2,
                      .max = 3.2,
                      .scale = 0.02,
                      .help = "Positive looks left, radians."}},
      .help = "The camera is turned in its last link.",
      .formula = "R_link,camera = Rz(yaw) Ry(pitch) Rx(roll) before the axes of the camera",
      .signature = "rotation of the image field",
      .example = "mount_misalignment: {yaw_rad: 0.02}",
      .family = Family::pointing,
      .advice = {{kLandmarks,
                  {"frame_latency"},
                  "Turn both ways: a latency changes its sign with the turn, a mount does not."},
                 {kLandmarks,
                  {"bearing_scale"},
                  "See landmarks on both sides: a scale changes its sign, a mount does not."}},
      .mount = [](Values p, Pose& X_LC) { X_LC.R = X_LC.R * rotation_zyx(p[0], p[1], p[2]); },
      .proof = {{.values = {0.1, -0.2, 0.3},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
                 .expected = {{"link_x_m", 1.23239523635429},
                              {"link_y_m", 0.0478677016356334},
                              {"link_z_m", 0.414017710432013}},
                 .source = "python: turned(*p, x_m, y_m, z_m)[0], turned(*p, x_m, y_m, z_m)[1], "
                           "turned(*p, x_m, y_m, z_m)[2]"},
                {.values = {0, 0.05, 0},
                 .given = {{"z_m", 1}},
                 .expected = {{"link_x_m", 0.998750260394966}, {"link_z_m", -0.0499791692706783}},
                 .source = "python: math.cos(p[1]), -math.sin(p[1])"}},
  };
}

}  // namespace seam::effects
