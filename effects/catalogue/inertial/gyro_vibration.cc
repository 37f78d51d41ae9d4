#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition gyro_vibration() {
  return {
      .name = "gyro_vibration",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = vibration_parameters("radps", 100, 2e-4, "rms, rad/s.",
                                         {0, 5, "ranges of gyroscopes end at 4 to 35 rad/s"}),
      .help =
          "A line in the readings of the gyroscope: a motor, or a resonance of what it is "
          "mounted on.",
      .formula =
          "autocovariance rms^2 exp(-pi f |lag| / quality) (cos(2 pi f lag) + skew / (2 quality) "
          "sin(2 "
          "pi f |lag|))",
      .signature = "power about one frequency; a wave in the Allan deviation",
      .example =
          "gyro_vibration: {x_radps: 0.02, y_radps: 0.02, z_radps: 0.02, frequency_hz: 42, "
          "quality: 84}",
      .starts = {{kImu, StartSearch::frequency}},
      .advice =
          {{kImu,
            {"gyro_white_noise", "gyro_quantisation"},
            "samples at a higher rate: a line keeps its frequency unless it is a mirrored one, "
            "rounding and white noise have none"},
           {kImu, {}, "the same rest with motors and fans off"}},
      .noise = [](Values p,
                  Noise& errors) { errors.inertial.gyro.vibrations.push_back(vibration(p)); },
      .proof = {{.values = {0.01, 0.02, 0.03, 20, 40, 0},
                 .given = {{"frequency_hz", 20.5}, {"rate_hz", 100}},
                 .expected = {{"wx_power", 0.00127380030409693},
                              {"wy_power", 0.00509520121638771},
                              {"wz_power", 0.0114642027368724}},
                 .source =
                     "python: p[0]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz), "
                     "p[1]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz), p[2]**2 "
                     "* vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)"},
                {.values = {0.3, 0.1, 0.2, 90, 30, 0.8},
                 .given = {{"frequency_hz", 30}, {"rate_hz", 200}},
                 .expected = {{"wx_power", 0.003031864429914},
                              {"wy_power", 0.000336873825546001},
                              {"wz_power", 0.001347495302184}},
                 .source =
                     "python: p[0]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz), "
                     "p[1]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz), p[2]**2 "
                     "* vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)"}},
  };
}

}  // namespace seam::effects
