#include <cmath>

#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

EffectDefinition camera_pose() {
  const auto shift = [](const char* name, const char* help) {
    return Parameter{
        .name = name, .min = -100, .max = 100, .scale = 0.01, .help = help, .required = true};
  };
  const auto turn = [](const char* name, const char* help) {
    return Parameter{
        .name = name, .min = -7, .max = 7, .scale = 0.01, .help = help, .required = true};
  };
  return {
      .name = "camera_pose",
      .stage = Stage::mount,
      .kinds = kPoints,
      .parameters = {shift("x_m", "To the right of the first camera, metres."),
                     shift("y_m", "Below it, metres."), shift("z_m", "Before it, metres."),
                     turn("rx_rad", "Turn about the first camera's x (right), radians."),
                     turn("ry_rad", "Turn about its y (down), radians."),
                     turn("rz_rad", "Turn about its z (forward), radians.")},
      .help =
          "Where one of several cameras on a rig is beside the first: camera_pose@NAME. The "
          "turn is one rotation about the axis (rx, ry, rz) by its length.",
      .formula = "p_first = R(rx, ry, rz) p_camera + (x, y, z)",
      .signature = "one camera's points displaced against the other's",
      .example = "camera_pose: {x_m: 0.12, y_m: 0, z_m: 0, rx_rad: 0, ry_rad: 0, rz_rad: 0}",
      .has_neutral = false,
      .mount =
          [](Values p, Pose& X_LC) {
            const Vec3 by(p[3], p[4], p[5]);
            const double angle = std::sqrt(by.x * by.x + by.y * by.y + by.z * by.z);
            const Pose X_FC = {angle > 0 ? rotation_about(by / angle, angle) : Mat3(1.0),
                               Vec3(p[0], p[1], p[2])};
            const Pose X_LF = rotation(link_to_camera_axes());
            X_LC = X_LC * X_LF * X_FC * X_LF.inverse();
          },
      .proof = {{.values = {0.1, -0.2, 0.3, 0, 0, 0},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
                 .expected = {{"link_x_m", 1.55}, {"link_y_m", -0.4}, {"link_z_m", 0.4}},
                 .source = "python: z_m + p[2], -x_m - p[0], -y_m - p[1]"},
                {.values = {0, 0, 0, 0, 1.5707963267949, 0},
                 .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}},
                 .expected = {{"link_x_m", 0.45}, {"link_y_m", -0.75}, {"link_z_m", -0.3}},
                 .source = "python: -x_m, -z_m, -y_m"}},
  };
}

}  // namespace seam::effects
