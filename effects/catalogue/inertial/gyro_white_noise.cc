#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition gyro_white_noise() {
  return {
      .name = "gyro_white_noise",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = axis_parameters("radps_rthz", 0, 10, 2e-4, "density, rad/s / sqrt(Hz).",
                                    {0, 0.01, "data sheets of MEMS: 5e-5 to 2e-3"}),
      .help = "White noise of the gyroscope: angle random walk, N of IEEE 952.",
      .formula = "power N^2 / dt at every frequency; Allan deviation N / sqrt(tau)",
      .signature = "power of the noise at high frequencies",
      .example = "gyro_white_noise: {x_radps_rthz: 2e-4, y_radps_rthz: 2e-4, z_radps_rthz: 2e-4}",
      .starts = noise_starts(1e-7, 1),
      .advice = {{kImu,
                  {"gyro_quantisation"},
                  "samples at a higher rate: white noise keeps its density, rounding does not"}},
      .noise = [](Values p, Noise& errors) { add_noise(errors.inertial.gyro.white, p); },
      .proof = {{.values = {0.01, 0.02, 0.03},
                 .given = {{"frequency_hz", 1}, {"rate_hz", 100}},
                 .expected = {{"wx_power", 0.01}, {"wy_power", 0.04}, {"wz_power", 0.09}},
                 .source = "python: p[0]**2 * rate_hz, p[1]**2 * rate_hz, p[2]**2 * rate_hz"},
                {.values = {0.3, 0.1, 0.2},
                 .given = {{"frequency_hz", 40}, {"rate_hz", 200}},
                 .expected = {{"wx_power", 18}, {"wy_power", 2}, {"wz_power", 8}},
                 .source = "python: p[0]**2 * rate_hz, p[1]**2 * rate_hz, p[2]**2 * rate_hz"}},
  };
}

}  // namespace seam::effects
