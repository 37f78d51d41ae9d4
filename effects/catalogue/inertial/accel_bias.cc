#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition accel_bias() {
  return {
      .name = "accel_bias",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = axis_parameters("mps2", -50, 50, 0.02, "m/s^2.",
                                    {-2, 2, "data sheets of MEMS: within a tenth of g"}),
      .help = "What the accelerometer reports beside the truth, at 25 degrees Celsius.",
      .formula = "true + bias",
      .signature = "a size of gravity that changes with the attitude",
      .example = "accel_bias: {x_mps2: 0.02, y_mps2: 0.02, z_mps2: 0.02}",
      .advice = {{kImu, {"accel_temperature"}, "rests at other temperatures"}},
      .noise = [](Values p, Noise& errors) { add_to(errors.inertial.accel.bias, p); },
      .proof = {{.values = {0.01, -0.02, 0.03},
                 .expected = {{"ax_mps2", 0.01}, {"ay_mps2", -0.02}, {"az_mps2", 0.03}},
                 .source = "python: p[0], p[1], p[2]"},
                {.values = {-0.5, 0.25, 0.125},
                 .given = {{"ax_mps2", 1}, {"ay_mps2", 2}, {"az_mps2", 3}},
                 .expected = {{"ax_mps2", 0.5}, {"ay_mps2", 2.25}, {"az_mps2", 3.125}},
                 .source = "python: 1 + p[0], 2 + p[1], 3 + p[2]"}},
  };
}

}  // namespace seam::effects
