#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition gyro_scale() {
  return {
      .name = "gyro_scale",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = axis_parameters("scale", -0.5, 0.5, 0.005, "relative error.",
                                    {-0.1, 0.1, "data sheets of MEMS: within 3 %"}),
      .help = "Scale errors of the gyroscope.",
      .formula = "(1 + scale) * true",
      .signature = "an error that grows with the rate",
      .example = "gyro_scale: {x_scale: 0.005, y_scale: 0.005, z_scale: 0.005}",
      .advice = {{kImu,
                  {"gyro_bias"},
                  "turns both ways: a scale changes its sign, a bias does not"}},
      .noise = [](Values p, Noise& errors) { add_to(errors.inertial.gyro.scale, p); },
      .proof = {{.values = {0.01, -0.02, 0.03},
                 .given = {{"wx_radps", 1}, {"wy_radps", 2}, {"wz_radps", -3}},
                 .expected = {{"wx_radps", 1.01}, {"wy_radps", 1.96}, {"wz_radps", -3.09}},
                 .source = "python: 1 + p[0], 2 * (1 + p[1]), -3 * (1 + p[2])"},
                {.values = {0.2, 0.1, -0.1},
                 .given = {{"wx_radps", 9}, {"wy_radps", -8}, {"wz_radps", 7}},
                 .expected = {{"wx_radps", 10.8}, {"wy_radps", -8.8}, {"wz_radps", 6.3}},
                 .source = "python: 9 * (1 + p[0]), -8 * (1 + p[1]), 7 * (1 + p[2])"}},
  };
}

}  // namespace seam::effects
