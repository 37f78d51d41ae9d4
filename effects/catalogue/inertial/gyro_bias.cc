#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition gyro_bias() {
  return {
      .name = "gyro_bias",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = axis_parameters("radps", -10, 10, 1e-3, "rad/s.",
                                    {-0.5, 0.5, "data sheets of MEMS: within 20 degrees/s"}),
      .help = "What the gyroscope reports beside the truth, at 25 degrees Celsius.",
      .formula = "true + bias",
      .signature = "a mean at rest that is not zero",
      .example = "gyro_bias: {x_radps: 1e-3, y_radps: 1e-3, z_radps: 1e-3}",
      .advice = {{kImu, {"gyro_temperature"}, "rests at other temperatures"}},
      .noise = [](Values p, Noise& errors) { add_to(errors.inertial.gyro.bias, p); },
      .proof = {{.values = {0.01, -0.02, 0.03},
                 .expected = {{"wx_radps", 0.01}, {"wy_radps", -0.02}, {"wz_radps", 0.03}},
                 .source = "python: p[0], p[1], p[2]"},
                {.values = {-0.5, 0.25, 0.125},
                 .given = {{"wx_radps", 1}, {"wy_radps", 2}, {"wz_radps", 3}},
                 .expected = {{"wx_radps", 0.5}, {"wy_radps", 2.25}, {"wz_radps", 3.125}},
                 .source = "python: 1 + p[0], 2 + p[1], 3 + p[2]"}},
  };
}

}  // namespace seam::effects
