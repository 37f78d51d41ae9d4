#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition accel_white_noise() {
  return {
      .name = "accel_white_noise",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = axis_parameters("mps2_rthz", 0, 100, 2e-3, "density, m/s^2 / sqrt(Hz).",
                                    {0, 0.05, "data sheets of MEMS: 5e-4 to 5e-3"}),
      .help = "White noise of the accelerometer: velocity random walk, N of IEEE 952.",
      .formula = "power N^2 / dt at every frequency; Allan deviation N / sqrt(tau)",
      .signature = "power of the noise at high frequencies",
      .example = "accel_white_noise: {x_mps2_rthz: 2e-3, y_mps2_rthz: 2e-3, z_mps2_rthz: 2e-3}",
      .starts = noise_starts(1e-6, 10),
      .advice = {{kImu,
                  {"accel_quantisation"},
                  "samples at a higher rate: white noise keeps its density, rounding does not"}},
      .noise = [](Values p, Noise& errors) { add_noise(errors.inertial.accel.white, p); },
      .proof = {{.values = {0.01, 0.02, 0.03},
                 .given = {{"frequency_hz", 1}, {"rate_hz", 100}},
                 .expected = {{"ax_power", 0.01}, {"ay_power", 0.04}, {"az_power", 0.09}},
                 .source = "python: p[0]**2 * rate_hz, p[1]**2 * rate_hz, p[2]**2 * rate_hz"},
                {.values = {0.3, 0.1, 0.2},
                 .given = {{"frequency_hz", 40}, {"rate_hz", 200}},
                 .expected = {{"ax_power", 18}, {"ay_power", 2}, {"az_power", 8}},
                 .source = "python: p[0]**2 * rate_hz, p[1]**2 * rate_hz, p[2]**2 * rate_hz"}},
  };
}

}  // namespace seam::effects
