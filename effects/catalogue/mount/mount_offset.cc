#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition mount_offset() {
  return {
      .name = "mount_offset",
      .stage = Stage::mount,
      .kinds = kPoints | kLandmarks | kRanges | kFrames,
      .parameters =
          {{.name = "x_m", .min = -0.5, .max = 0.5, .scale = 0.01, .help = "Forward, metres."},
           {.name = "y_m", .min = -0.5, .max = 0.5, .scale = 0.01, .help = "To the left, metres."},
           {.name = "z_m", .min = -0.5, .max = 0.5, .scale = 0.01, .help = "Up, metres."}},
      .help = "The camera is shifted in its last link.",
      .formula = "p_link,camera += (x, y, z)",
      .signature = "displacement grows as points come near",
      .example = "mount_offset: {x_m: 0.005}",
      .mount = [](Values p, Pose& X_LC) { X_LC.p += Vec3(p[0], p[1], p[2]); },
  };
}

}  // namespace seam::effects
