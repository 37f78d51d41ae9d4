#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition gyro_temperature() {
  return {
      .name = "gyro_temperature",
      .stage = kInertial,
      .kinds = kImu,
      .parameters =
          axis_parameters("radps_k", -1, 1, 1e-5, "rad/s a kelvin.",
                          {-0.01, 0.01, "data sheets of MEMS: 0.01 to 0.1 degrees/s a kelvin"}),
      .help = "The bias of the gyroscope changes with its temperature.",
      .formula = "true + c (T - 25)",
      .signature = "a mean that follows the temperature",
      .example = "gyro_temperature: {x_radps_k: 1e-5, y_radps_k: 1e-5, z_radps_k: 1e-5}",
      .noise = [](Values p, Noise& errors) { add_to(errors.inertial.gyro.per_k, p); },
      .proof = {{.values = {0.01, -0.02, 0.03},
                 .given = {{"temperature_c", 35}},
                 .expected = {{"wx_radps", 0.1}, {"wy_radps", -0.2}, {"wz_radps", 0.3}},
                 .source = "python: 10 * p[0], 10 * p[1], 10 * p[2]"},
                {.values = {0.1, 0.2, 0.3},
                 .given = {{"temperature_c", 5}},
                 .expected = {{"wx_radps", -2}, {"wy_radps", -4}, {"wz_radps", -6}},
                 .source = "python: -20 * p[0], -20 * p[1], -20 * p[2]"}},
  };
}

}  // namespace seam::effects
