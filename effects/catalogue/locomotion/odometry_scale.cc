#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

EffectDefinition odometry_scale() {
  const auto scale = [](const char* name, const char* what, Need need) {
    return Parameter{
        .name = name,
        .min = -0.9,
        .max = 3,
        .scale = 0.05,
        .help = std::string("Relative error of the ") + what +
                " speed; positive: faster than commanded.",
        .needs = {need},
        .plausible = {-0.6, 1, "legs go half as far or twice as far as asked, no more"}};
  };
  return {
      .name = "odometry_scale",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {scale("vx_scale", "forward", Need::forward_walk),
                     scale("vy_scale", "sideways", Need::sideways_walk),
                     scale("omega_scale", "turning", Need::turning)},
      .help = "The gait makes longer or shorter steps, or turns more or less, than commanded.",
      .formula = "v (1 + scale)",
      .signature = "displacement with distance or turn",
      .example = "odometry_scale: {vx_scale: -0.1}",
      .needs = {Need::commanded_walk},
      .advice =
          {{kOdometry, {"heading_drift"}, "straight walks without turning, and turns on the spot"},
           {kOdometry, {}, "long walks forward, sideways, and turns on the spot, one run each"}},
      .locomotion =
          [](Values p, Locomotion& walk) {
            walk.vx_scale += p[0];
            walk.vy_scale += p[1];
            walk.omega_scale += p[2];
          },
      .proof = {{.values = {-0.1, 0.2, 0.05},
                 .given = {{"vx_mps", 0.2}, {"vy_mps", -0.1}, {"omega_radps", 0.5}, {"for_s", 2}},
                 .expected = {{"x_m", 0.41224315211408},
                              {"y_m", -0.0260068108411615},
                              {"theta_rad", 1.05}},
                 .source = "python: walked(p, [((0.18, -0.12, 0.525), 2)])[0], walked(p, [((0.18, "
                           "-0.12, 0.525), 2)])[1], 0.525 * 2"},
                {.values = {0.5, 0, 0},
                 .given = {{"vx_mps", 0.2}, {"vy_mps", 0.1}, {"for_s", 3}},
                 .expected = {{"x_m", 0.9}, {"y_m", 0.3}},
                 .source = "python: 0.9, 0.3"}},
  };
}

}  // namespace seam::effects
