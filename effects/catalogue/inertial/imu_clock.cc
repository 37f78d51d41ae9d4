#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition imu_clock() {
  return {
      .name = "imu_clock",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = {{.name = "drift_ppm",
                      .min = -200000,
                      .max = 200000,
                      .scale = 1e3,
                      .help = "How much faster than the host's clock the sensor's own runs, parts "
                              "per million.",
                      .plausible = {-50000, 50000,
                                    "quartz keeps 100 ppm; data sheets of MEMS: 1 to 5 %"}}},
      .help = "The sensor samples by its own clock, which is not the one that stamps the samples.",
      .formula = "distance of samples 1 / (rate_hz (1 + drift * 1e-6))",
      .signature = "another rate of samples than the data sheet has",
      .example = "imu_clock: {drift_ppm: 4000}",
      .advice = {{kImu, {}, "a longer stretch, stamped by a clock that you trust"}},
      .noise = [](Values p, Noise& errors) { errors.inertial.clock_ppm += p[0]; },
      .proof = {{.values = {4000},
                 .given = {{"rate_hz", 200}},
                 .expected = {{"sample_distance_s", 0.0049800796812749}},
                 .source = "python: 1 / (rate_hz * (1 + p[0] * 1e-6))"},
                {.values = {-150},
                 .expected = {{"sample_distance_s", 0.0100015002250338}},
                 .source = "python: 1 / (100 * (1 + p[0] * 1e-6))"}},
  };
}

}  // namespace seam::effects
