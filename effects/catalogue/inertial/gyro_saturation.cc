#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition gyro_saturation() {
  return {
      .name = "gyro_saturation",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = {{.name = "most_radps",
                      .neutral = kNever,
                      .min = 1e-3,
                      .max = kNever,
                      .scale = 10,
                      .help = "The end of its range, rad/s.",
                      .fit_reciprocal = true}},
      .help = "The gyroscope reports no more than this.",
      .formula = "clipped to -most .. most",
      .signature = "a mean that stays behind at the largest values",
      .example = "gyro_saturation: {most_radps: 35}",
      .starts = {{kImu, StartSearch::ceiling}},
      .noise = [](Values p, Noise& errors) { errors.inertial.gyro.most = p[0]; },
      .proof = {{.values = {2},
                 .given = {{"wx_radps", 1}, {"wy_radps", 5}, {"wz_radps", -6}},
                 .expected = {{"wx_radps", 1}, {"wy_radps", 2}, {"wz_radps", -2}},
                 .source = "python: 1, p[0], -p[0]"},
                {.values = {7.5},
                 .given = {{"wx_radps", 8}, {"wy_radps", -9}, {"wz_radps", 3}},
                 .expected = {{"wx_radps", 7.5}, {"wy_radps", -7.5}, {"wz_radps", 3}},
                 .source = "python: p[0], -p[0], 3"}},
  };
}

}  // namespace seam::effects
