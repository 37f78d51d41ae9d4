#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition accel_quantisation() {
  return {
      .name = "accel_quantisation",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = axis_parameters("mps", 0, 1, 1e-5, "Q, m/s: step / sqrt(12)."),
      .help = "The accelerometer reports differences of a velocity that it rounds: Q of IEEE 952.",
      .formula = "power Q^2 (2 sin(pi f dt))^2 / dt^2; Allan deviation sqrt(3) Q / tau",
      .signature = "power that grows as f^2; an Allan deviation that falls as 1 / tau",
      .example = "accel_quantisation: {x_mps: 1e-5, y_mps: 1e-5, z_mps: 1e-5}",
      .starts = noise_starts(1e-8, 1e-1),
      .noise = [](Values p, Noise& errors) { add_noise(errors.inertial.accel.rounding, p); },
      .proof =
          {{.values = {0.01, 0.02, 0.03},
            .given = {{"frequency_hz", 1}, {"rate_hz", 100}},
            .expected = {{"ax_power", 0.00394654314345688},
                         {"ay_power", 0.0157861725738275},
                         {"az_power", 0.0355188882911119}},
            .source =
                "python: (p[0] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2, "
                "(p[1] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2, (p[2] * "
                "rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2"},
           {.values = {0.3, 0.1, 0.2},
            .given = {{"frequency_hz", 40}, {"rate_hz", 200}},
            .expected = {{"ax_power", 4975.07764050038},
                         {"ay_power", 552.786404500042},
                         {"az_power", 2211.14561800017}},
            .source =
                "python: (p[0] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2, "
                "(p[1] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2, (p[2] * "
                "rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2"}},
  };
}

}  // namespace seam::effects
