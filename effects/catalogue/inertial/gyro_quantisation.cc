#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition gyro_quantisation() {
  return {
      .name = "gyro_quantisation",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = axis_parameters("rad", 0, 1, 1e-6, "Q, rad: step / sqrt(12)."),
      .help = "The gyroscope reports differences of an angle that it rounds: Q of IEEE 952.",
      .formula = "power Q^2 (2 sin(pi f dt))^2 / dt^2; Allan deviation sqrt(3) Q / tau",
      .signature = "power that grows as f^2; an Allan deviation that falls as 1 / tau",
      .example = "gyro_quantisation: {x_rad: 1e-6, y_rad: 1e-6, z_rad: 1e-6}",
      .starts = noise_starts(1e-9, 1e-2),
      .noise = [](Values p, Noise& errors) { add_noise(errors.inertial.gyro.rounding, p); },
      .proof =
          {{.values = {0.01, 0.02, 0.03},
            .given = {{"frequency_hz", 1}, {"rate_hz", 100}},
            .expected = {{"wx_power", 0.00394654314345688},
                         {"wy_power", 0.0157861725738275},
                         {"wz_power", 0.0355188882911119}},
            .source =
                "python: (p[0] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2, "
                "(p[1] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2, (p[2] * "
                "rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2"},
           {.values = {0.3, 0.1, 0.2},
            .given = {{"frequency_hz", 40}, {"rate_hz", 200}},
            .expected = {{"wx_power", 4975.07764050038},
                         {"wy_power", 552.786404500042},
                         {"wz_power", 2211.14561800017}},
            .source =
                "python: (p[0] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2, "
                "(p[1] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2, (p[2] * "
                "rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2"}},
  };
}

}  // namespace seam::effects
