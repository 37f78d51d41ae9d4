#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition gyro_misalignment() {
  return {
      .name = "gyro_misalignment",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = cross_parameters({"xy", "xz", "yx", "yz", "zx", "zy"}),
      .help = "Axes of the gyroscope that are not where they should be.",
      .formula = "an axis (the first letter) has so much of another one (the second)",
      .signature = "a rate about one axis shows on the others",
      .example = "gyro_misalignment: {xy_rad: 0.005, zx_rad: -0.003}",
      .noise =
          [](Values p, Noise& errors) {
            errors.inertial.gyro.cross[0][1] += p[0], errors.inertial.gyro.cross[0][2] += p[1];
            errors.inertial.gyro.cross[1][0] += p[2], errors.inertial.gyro.cross[1][2] += p[3];
            errors.inertial.gyro.cross[2][0] += p[4], errors.inertial.gyro.cross[2][1] += p[5];
          },
      .proof = {{.values = {0.01, -0.02, 0.03, 0.04, -0.05, 0.06},
                 .given = {{"wx_radps", 1}, {"wy_radps", 2}, {"wz_radps", 3}},
                 .expected = {{"wx_radps", 0.96}, {"wy_radps", 2.15}, {"wz_radps", 3.07}},
                 .source = "python: 1 + p[0] * 2 + p[1] * 3, 2 + p[2] * 1 + p[3] * 3, 3 + p[4] * 1 "
                           "+ p[5] * 2"},
                {.values = {0.1, 0.2, -0.3, 0.15, 0.25, -0.35},
                 .given = {{"wx_radps", 5}, {"wy_radps", -4}, {"wz_radps", 2}},
                 .expected = {{"wx_radps", 5}, {"wy_radps", -5.2}, {"wz_radps", 4.65}},
                 .source = "python: 5 + p[0] * -4 + p[1] * 2, -4 + p[2] * 5 + p[3] * 2, 2 + p[4] * "
                           "5 + p[5] * -4"}},
  };
}

}  // namespace seam::effects
