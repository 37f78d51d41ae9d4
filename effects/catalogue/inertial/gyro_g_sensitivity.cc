#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition gyro_g_sensitivity() {
  return {
      .name = "gyro_g_sensitivity",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = axis_parameters("radps_mps2", -0.1, 0.1, 1e-4, "(rad/s) / (m/s^2).",
                                    {-0.005, 0.005, "data sheets of MEMS: 0.1 degrees/s for g"}),
      .help = "A gyroscope's axis that shows the specific force along it.",
      .formula = "true + g * force along the axis",
      .signature = "a mean rate that changes with the attitude",
      .example = "gyro_g_sensitivity: {x_radps_mps2: 1e-4, y_radps_mps2: 1e-4, z_radps_mps2: 1e-4}",
      .noise = [](Values p, Noise& errors) { add_to(errors.inertial.gyro_per_force, p); },
      .proof = {{.values = {0.001, 0.002, -0.003},
                 .given = {{"wx_radps", 1}, {"ax_mps2", 2}, {"ay_mps2", 3}, {"az_mps2", 9}},
                 .expected = {{"wx_radps", 1.002}, {"wy_radps", 0.006}, {"wz_radps", -0.027}},
                 .source = "python: 1 + 2 * p[0], 3 * p[1], 9 * p[2]"},
                {.values = {-0.01, 0.02, 0.03},
                 .given = {{"ax_mps2", 9.8}, {"ay_mps2", -9.8}, {"az_mps2", 4}},
                 .expected = {{"wx_radps", -0.098}, {"wy_radps", -0.196}, {"wz_radps", 0.12}},
                 .source = "python: 9.8 * p[0], -9.8 * p[1], 4 * p[2]"}},
  };
}

}  // namespace seam::effects
