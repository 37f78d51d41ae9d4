#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition accel_misalignment() {
  return {
      .name = "accel_misalignment",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = cross_parameters({"yx", "zx", "zy"}),
      .help =
          "Axes of the accelerometer that are not at right angles. What turns all of them belongs "
          "to the mount.",
      .formula = "an axis (the first letter) has so much of another one (the second)",
      .signature = "a size of gravity that is wrong between the axes",
      .example = "accel_misalignment: {yx_rad: 0.005, zx_rad: -0.003}",
      .noise =
          [](Values p, Noise& errors) {
            errors.inertial.accel.cross[1][0] += p[0], errors.inertial.accel.cross[2][0] += p[1],
                errors.inertial.accel.cross[2][1] += p[2];
          },
      .proof = {{.values = {0.01, -0.02, 0.03},
                 .given = {{"ax_mps2", 1}, {"ay_mps2", 2}, {"az_mps2", 3}},
                 .expected = {{"ax_mps2", 1}, {"ay_mps2", 2.01}, {"az_mps2", 3.04}},
                 .source = "python: 1, 2 + p[0] * 1, 3 + p[1] * 1 + p[2] * 2"},
                {.values = {0.1, 0.2, -0.3},
                 .given = {{"ax_mps2", 5}, {"ay_mps2", -4}, {"az_mps2", 2}},
                 .expected = {{"ax_mps2", 5}, {"ay_mps2", -3.5}, {"az_mps2", 4.2}},
                 .source = "python: 5, -4 + p[0] * 5, 2 + p[1] * 5 + p[2] * -4"}},
  };
}

}  // namespace seam::effects
