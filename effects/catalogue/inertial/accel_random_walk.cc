#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition accel_random_walk() {
  return {
      .name = "accel_random_walk",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = axis_parameters("mps3_rthz", 0, 10, 1e-4, "K, m/s^3 / sqrt(Hz)."),
      .help = "The bias of the accelerometer is a random walk: K of IEEE 952.",
      .formula = "power K^2 dt / (2 sin(pi f dt))^2; Allan deviation K sqrt(tau / 3)",
      .signature = "power that grows as 1 / f^2; an Allan deviation that rises",
      .example = "accel_random_walk: {x_mps3_rthz: 1e-4, y_mps3_rthz: 1e-4, z_mps3_rthz: 1e-4}",
      .starts = noise_starts(1e-8, 1),
      .advice = {{kImu,
                  {"accel_temperature"},
                  "rests at constant warmth: a walk stays, an effect of temperature goes"}},
      .noise = [](Values p, Noise& errors) { add_noise(errors.inertial.accel.walk, p); },
      .proof =
          {{.values = {0.01, 0.02, 0.03},
            .given = {{"frequency_hz", 1}, {"rate_hz", 100}},
            .expected = {{"ax_power", 0.000253386308891096},
                         {"ay_power", 0.00101354523556438},
                         {"az_power", 0.00228047678001986}},
            .source =
                "python: p[0]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2, "
                "p[1]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2, p[2]**2 "
                "/ rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2"},
           {.values = {0.3, 0.1, 0.2},
            .given = {{"frequency_hz", 40}, {"rate_hz", 200}},
            .expected = {{"ax_power", 0.000325623058987491},
                         {"ay_power", 3.6180339887499e-05},
                         {"az_power", 0.000144721359549996}},
            .source =
                "python: p[0]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2, "
                "p[1]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2, p[2]**2 "
                "/ rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2"}},
  };
}

}  // namespace seam::effects
