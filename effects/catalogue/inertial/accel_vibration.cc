#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition accel_vibration() {
  return {
      .name = "accel_vibration",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = vibration_parameters(
          "mps2", 1000, 0.2, "rms, m/s^2.",
          {0, 30, "ArduPilot, Measuring Vibration: up to 15 m/s^2 fly well, above 30 do not"}),
      .help =
          "A line in the readings of the accelerometer: a motor, or a resonance of what it is "
          "mounted on.",
      .formula =
          "autocovariance rms^2 exp(-pi f |lag| / quality) (cos(2 pi f lag) + skew / (2 quality) "
          "sin(2 "
          "pi f |lag|))",
      .signature = "power about one frequency; a wave in the Allan deviation",
      .example =
          "accel_vibration: {x_mps2: 0.2, y_mps2: 0.2, z_mps2: 0.2, frequency_hz: 42, quality: "
          "84}",
      .starts = {{kImu, StartSearch::frequency}},
      .advice =
          {{kImu,
            {"accel_white_noise", "accel_quantisation"},
            "samples at a higher rate: a line keeps its frequency unless it is a mirrored one, "
            "rounding and white noise have none"},
           {kImu, {}, "the same rest with motors and fans off"}},
      .noise = [](Values p,
                  Noise& errors) { errors.inertial.accel.vibrations.push_back(vibration(p)); },
      .proof = {{.values = {0.01, 0.02, 0.03, 20, 40, 0},
                 .given = {{"frequency_hz", 20.5}, {"rate_hz", 100}},
                 .expected = {{"ax_power", 0.00127380030409693},
                              {"ay_power", 0.00509520121638771},
                              {"az_power", 0.0114642027368724}},
                 .source =
                     "python: p[0]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz), "
                     "p[1]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz), p[2]**2 "
                     "* vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)"},
                {.values = {0.3, 0.1, 0.2, 90, 30, 0.8},
                 .given = {{"frequency_hz", 30}, {"rate_hz", 200}},
                 .expected = {{"ax_power", 0.003031864429914},
                              {"ay_power", 0.000336873825546001},
                              {"az_power", 0.001347495302184}},
                 .source =
                     "python: p[0]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz), "
                     "p[1]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz), p[2]**2 "
                     "* vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)"}},
  };
}

}  // namespace seam::effects
