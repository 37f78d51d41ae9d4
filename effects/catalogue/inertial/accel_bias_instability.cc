#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition accel_bias_instability() {
  return {
      .name = "accel_bias_instability",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = axis_parameters("mps2", 0, 100, 1e-3, "B, m/s^2.",
                                    {0, 0.05, "data sheets of MEMS: 1e-4 to 5e-3"}),
      .help =
          "Flicker noise of the accelerometer: its bias wanders with as much power in each octave. "
          "B of IEEE 952: the flat of the Allan deviation is 0.664 B.",
      .formula = "power B^2 / (2 sin(pi f dt)); Allan deviation 0.664 B",
      .signature = "power that grows as 1 / f; a flat floor of the Allan deviation",
      .example = "accel_bias_instability: {x_mps2: 1e-3, y_mps2: 1e-3, z_mps2: 1e-3}",
      .starts = noise_starts(1e-6, 10),
      .advice = {{kImu,
                  {"accel_random_walk", "accel_temperature"},
                  "a longer rest, with the temperature logged: the floor of the Allan deviation "
                  "stays flat for flicker noise and rises for a walk"}},
      .noise = [](Values p, Noise& errors) { add_noise(errors.inertial.accel.flicker, p); },
      .proof = {{.values = {0.01, 0.02, 0.03},
                 .given = {{"frequency_hz", 1}, {"rate_hz", 100}},
                 .expected = {{"ax_power", 0.00159181126045488},
                              {"ay_power", 0.00636724504181952},
                              {"az_power", 0.0143263013440939}},
                 .source = "python: p[0]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz)), "
                           "p[1]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz)), p[2]**2 / "
                           "(2 * math.sin(math.pi * frequency_hz / rate_hz))"},
                {.values = {0.3, 0.1, 0.2},
                 .given = {{"frequency_hz", 40}, {"rate_hz", 200}},
                 .expected = {{"ax_power", 0.0765585727516836},
                              {"ay_power", 0.0085065080835204},
                              {"az_power", 0.0340260323340816}},
                 .source = "python: p[0]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz)), "
                           "p[1]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz)), p[2]**2 / "
                           "(2 * math.sin(math.pi * frequency_hz / rate_hz))"}},
  };
}

}  // namespace seam::effects
