#include "effects/stages/inertial/inertial.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

EffectDefinition camera_imu_rotation() {
  std::vector<Parameter> parameters;
  for (const char* axis : {"x", "y", "z"})
    parameters.push_back({.name = std::string(axis) + "_rad",
                          .min = -4,
                          .max = 4,
                          .scale = 0.01,
                          .help = "Part along the sensor's " + std::string(axis) +
                                  " axis of the turn's vector, radians.",
                          .plausible = {-maths::kPi, maths::kPi, "a turn is at most half of one"}});
  return {
      .name = "camera_imu_rotation",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = std::move(parameters),
      .help =
          "The camera's axes (x right, y down, z forward) against those of an inertial sensor "
          "on the same body: one turn brings the sensor's to the camera's.",
      .formula = "rate in the sensor's axes = R * rate in the camera's, R the turn by this vector",
      .signature = "turns that the camera has about other axes",
      .example = "camera_imu_rotation: {x_rad: -1.57}",
      .advice = {{kImu, {}, "turns about at least two axes"}},
      .noise = [](Values p, Noise& errors) { add_to(errors.inertial.camera_turn_rad, p); },
      .proof =
          {{.values = {0.3, -0.2, 0.4},
            .given = {{"wx_camera_radps", 1}, {"wy_camera_radps", 2}, {"wz_camera_radps", 3}},
            .expected = {{"wx_turned_radps", -0.313786437721804},
                         {"wy_turned_radps", 1.13339236439902},
                         {"wz_turned_radps", 3.55203601049086}},
            .source = "python: spun(p, 1, 2, 3)[0], spun(p, 1, 2, 3)[1], spun(p, 1, 2, 3)[2]"},
           {.values = {-1.5, 0.1, 0.2},
            .given = {{"wx_camera_radps", 0.5}},
            .expected = {{"wx_turned_radps", 0.489719507326102},
                         {"wy_turned_radps", 0.03499966602345},
                         {"wz_turned_radps", -0.0946035280659602}},
            .source =
                "python: spun(p, 0.5, 0, 0)[0], spun(p, 0.5, 0, 0)[1], spun(p, 0.5, 0, 0)[2]"}},
  };
}

}  // namespace seam::effects
