#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition gyro_bias_instability() {
  return {
      .name = "gyro_bias_instability",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = axis_parameters("radps", 0, 10, 1e-4, "B, rad/s.",
                                    {0, 0.02, "data sheets of MEMS: 1 to 200 degrees an hour"}),
      .help =
          "Flicker noise of the gyroscope: its bias wanders with as much power in each octave. B "
          "of IEEE 952: the flat of the Allan deviation is 0.664 B.",
      .formula = "power B^2 / (2 sin(pi f dt)); Allan deviation 0.664 B",
      .signature = "power that grows as 1 / f; a flat floor of the Allan deviation",
      .example = "gyro_bias_instability: {x_radps: 1e-4, y_radps: 1e-4, z_radps: 1e-4}",
      .starts = noise_starts(1e-7, 1),
      .advice = {{kImu,
                  {"gyro_random_walk", "gyro_temperature"},
                  "a longer rest, with the temperature logged: the floor of the Allan deviation "
                  "stays flat for flicker noise and rises for a walk"}},
      .noise = [](Values p, Noise& errors) { add_noise(errors.inertial.gyro.flicker, p); },
      .proof = {{.values = {0.01, 0.02, 0.03},
                 .given = {{"frequency_hz", 1}, {"rate_hz", 100}},
                 .expected = {{"wx_power", 0.00159181126045488},
                              {"wy_power", 0.00636724504181952},
                              {"wz_power", 0.0143263013440939}},
                 .source = "python: p[0]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz)), "
                           "p[1]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz)), p[2]**2 / "
                           "(2 * math.sin(math.pi * frequency_hz / rate_hz))"},
                {.values = {0.3, 0.1, 0.2},
                 .given = {{"frequency_hz", 40}, {"rate_hz", 200}},
                 .expected = {{"wx_power", 0.0765585727516836},
                              {"wy_power", 0.0085065080835204},
                              {"wz_power", 0.0340260323340816}},
                 .source = "python: p[0]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz)), "
                           "p[1]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz)), p[2]**2 / "
                           "(2 * math.sin(math.pi * frequency_hz / rate_hz))"}},
  };
}

}  // namespace seam::effects
