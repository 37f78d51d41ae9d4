#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition mount_offset() {
  const auto offset = [](const char* name, const char* help, std::vector<Need> needs = {}) {
    return Parameter{.name = name,
                     .min = -0.5,
                     .max = 0.5,
                     .scale = 0.01,
                     .help = help,
                     .needs = std::move(needs),
                     .plausible = {-0.3, 0.3, "heads of robots are up to 0.3 m long"}};
  };
  return {
      .name = "mount_offset",
      .stage = Stage::mount,
      .kinds = kPoints | kLandmarks | kRanges | kFrames,
      .parameters = {offset("x_m", "Forward, metres."), offset("y_m", "To the left, metres."),
                     offset("z_m", "Up, metres.", {Need::space})},
      .help = "The camera is shifted in its last link.",
      .formula = "p_link,camera += (x, y, z)",
      .signature = "displacement grows as points come near",
      .example = "mount_offset: {x_m: 0.005}",
      .advice =
          {{kLandmarks,
            {"range_offset"},
            "See landmarks in all directions: an offset of the mount turns with the bearing."}},
      .mount = [](Values p, Pose& X_LC) { X_LC.p += Vec3(p[0], p[1], p[2]); },
      .proof = {{.values = {0.01, -0.02, 0.03},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
                 .expected = {{"link_x_m", 1.26}, {"link_y_m", -0.32}, {"link_z_m", 0.23}},
                 .source = "python: z_m + p[0], -x_m + p[1], -y_m + p[2]"},
                {.values = {0.2, 0, 0},
                 .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}},
                 .expected = {{"link_x_m", 0.95}, {"link_y_m", 0.45}, {"link_z_m", -0.3}},
                 .source = "python: z_m + p[0], -x_m, -y_m"}},
  };
}

}  // namespace seam::effects
