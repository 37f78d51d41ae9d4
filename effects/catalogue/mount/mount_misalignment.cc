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
                      .help = "About the optical axis, radians."},
                     {.name = "pitch_rad",
                      .min = -1,
                      .max = 1,
                      .scale = 0.02,
                      .help = "Positive looks down, radians."},
                     {.name = "yaw_rad",
                      .min = -3.2,
                      .max = 3.2,
                      .scale = 0.02,
                      .help = "Positive looks left, radians."}},
      .help = "The camera is turned in its last link.",
      .formula = "R_link,camera = Rz(yaw) Ry(pitch) Rx(roll) before the axes of the camera",
      .signature = "rotation of the image field",
      .example = "mount_misalignment: {yaw_rad: 0.02}",
      .mount = [](Values p, Pose& X_LC) { X_LC.R = X_LC.R * rotation_zyx(p[0], p[1], p[2]); },
  };
}

}  // namespace seam::effects
