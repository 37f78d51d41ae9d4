#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition accel_temperature() {
  return {
      .name = "accel_temperature",
      .stage = kInertial,
      .kinds = kImu,
      .parameters =
          axis_parameters("mps2_k", -1, 1, 1e-3, "m/s^2 a kelvin.",
                          {-0.1, 0.1, "data sheets of MEMS: 0.1 to 2 thousandths of g a kelvin"}),
      .help = "The bias of the accelerometer changes with its temperature.",
      .formula = "true + c (T - 25)",
      .signature = "a mean that follows the temperature",
      .example = "accel_temperature: {x_mps2_k: 1e-3, y_mps2_k: 1e-3, z_mps2_k: 1e-3}",
      .noise = [](Values p, Noise& errors) { add_to(errors.inertial.accel.per_k, p); },
      .proof = {{.values = {0.01, -0.02, 0.03},
                 .given = {{"temperature_c", 35}},
                 .expected = {{"ax_mps2", 0.1}, {"ay_mps2", -0.2}, {"az_mps2", 0.3}},
                 .source = "python: 10 * p[0], 10 * p[1], 10 * p[2]"},
                {.values = {0.1, 0.2, 0.3},
                 .given = {{"temperature_c", 5}},
                 .expected = {{"ax_mps2", -2}, {"ay_mps2", -4}, {"az_mps2", -6}},
                 .source = "python: -20 * p[0], -20 * p[1], -20 * p[2]"}},
  };
}

}  // namespace seam::effects
