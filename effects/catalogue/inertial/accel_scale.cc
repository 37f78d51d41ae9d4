#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition accel_scale() {
  return {
      .name = "accel_scale",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = axis_parameters("scale", -0.5, 0.5, 0.005, "relative error.",
                                    {-0.1, 0.1, "data sheets of MEMS: within 3 %"}),
      .help = "Scale errors of the accelerometer.",
      .formula = "(1 + scale) * true",
      .signature = "a size of gravity that is wrong by as much up as down",
      .example = "accel_scale: {x_scale: 0.005, y_scale: 0.005, z_scale: 0.005}",
      .advice = {{kImu,
                  {"accel_bias"},
                  "each axis up and down: a scale changes its sign, a bias does not"}},
      .noise = [](Values p, Noise& errors) { add_to(errors.inertial.accel.scale, p); },
      .proof = {{.values = {0.01, -0.02, 0.03},
                 .given = {{"ax_mps2", 1}, {"ay_mps2", 2}, {"az_mps2", -3}},
                 .expected = {{"ax_mps2", 1.01}, {"ay_mps2", 1.96}, {"az_mps2", -3.09}},
                 .source = "python: 1 + p[0], 2 * (1 + p[1]), -3 * (1 + p[2])"},
                {.values = {0.2, 0.1, -0.1},
                 .given = {{"ax_mps2", 9}, {"ay_mps2", -8}, {"az_mps2", 7}},
                 .expected = {{"ax_mps2", 10.8}, {"ay_mps2", -8.8}, {"az_mps2", 6.3}},
                 .source = "python: 9 * (1 + p[0]), -8 * (1 + p[1]), 7 * (1 + p[2])"}},
  };
}

}  // namespace seam::effects
