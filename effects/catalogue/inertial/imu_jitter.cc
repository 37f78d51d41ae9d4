#include "effects/stages/inertial/inertial.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

EffectDefinition imu_jitter() {
  return {
      .name = "imu_jitter",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = {{.name = "sigma_s",
                      .min = 0,
                      .max = 1,
                      .scale = 1e-3,
                      .help = "Standard deviation of a sample's time stamp, seconds.",
                      .plausible = {0, 0.02,
                                    "stamps that a computer gives come milliseconds late"}}},
      .help =
          "Time stamps of samples come early and late: the host reads its clock when it has "
          "time, or rounds it.",
      .formula = "stamp = time + error, normal with this sigma, new for each sample",
      .signature = "distances of stamps that scatter",
      .example = "imu_jitter: {sigma_s: 0.001}",
      .starts = {{kImu,
                  StartSearch::best_listed,
                  {{1e-5}, {3e-5}, {1e-4}, {3e-4}, {1e-3}, {3e-3}, {1e-2}, {3e-2}}}},
      .advice = {{kImu, {}, "stamps by the sensor's own interrupt"}},
      .noise =
          [](Values p, Noise& errors) {
            if (p[0] > 0)
              errors.inertial.stamp_sigma_s = std::hypot(errors.inertial.stamp_sigma_s, p[0]);
          },
      .proof =
          {{.values = {0.001}, .expected = {{"stamp_sigma_s", 0.001}}, .source = "python: p[0]"},
           {.values = {0.02}, .expected = {{"stamp_sigma_s", 0.02}}, .source = "python: p[0]"}},
  };
}

}  // namespace seam::effects
