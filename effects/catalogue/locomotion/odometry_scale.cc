#include "effects/stages/locomotion.h"

namespace seam::effects {

EffectDefinition odometry_scale() {
  const auto scale = [](const char* name, const char* what) {
    return Parameter{.name = name,
                     .min = -0.9,
                     .max = 3,
                     .scale = 0.05,
                     .help = std::string("Relative error of the ") + what +
                             " speed; positive: faster than commanded."};
  };
  return {
      .name = "odometry_scale",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {scale("vx_scale", "forward"), scale("vy_scale", "sideways"),
                     scale("omega_scale", "turning")},
      .help = "The gait makes longer or shorter steps, or turns more or less, than commanded.",
      .formula = "v (1 + scale)",
      .signature = "displacement with distance or turn",
      .example = "odometry_scale: {vx_scale: -0.1}",
      .locomotion =
          [](Values p, Locomotion& walk) {
            walk.vx_scale += p[0];
            walk.vy_scale += p[1];
            walk.omega_scale += p[2];
          },
  };
}

}  // namespace seam::effects
