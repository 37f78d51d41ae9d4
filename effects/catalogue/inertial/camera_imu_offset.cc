#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition camera_imu_offset() {
  return {
      .name = "camera_imu_offset",
      .stage = kInertial,
      .kinds = kImu,
      .parameters =
          {{.name = "offset_s",
            .min = -0.5,
            .max = 0.5,
            .scale = 1e-3,
            .help = "Time of the sensor less that of the camera, of the same event, seconds.",
            .plausible = {-0.2, 0.2, "published calibrations of phones and cameras: within 0.1 s"}},
           {.name = "of_exposure",
            .min = -2,
            .max = 2,
            .scale = 0.1,
            .help = "So much of the exposure is added: 0.5 where the camera stamps its start, -0.5 "
                    "where it stamps its end.",
            .on_demand = true,
            .plausible = {-1, 1, "a stamp lies within the exposure or at an end of it"}}},
      .help = "A camera and an inertial sensor on one body stamp the same event unlike.",
      .formula = "time of the sensor = time of the camera + offset + of_exposure * exposure",
      .signature = "turns of the camera that the gyroscope has earlier or later",
      .example = "camera_imu_offset: {offset_s: 0.005}",
      .advice = {{kImu, {}, "quick turns about all axes, to and fro"}},
      .noise =
          [](Values p, Noise& errors) {
            errors.inertial.camera_offset_s += p[0];
            errors.inertial.camera_offset_of_exposure += p[1];
          },
      .proof = {{.values = {0.005, 0.5},
                 .given = {{"exposure_s", 0.008}},
                 .expected = {{"camera_offset_s", 0.009}},
                 .source = "python: p[0] + p[1] * exposure_s"},
                {.values = {-0.02, -0.5},
                 .given = {{"exposure_s", 0.01}},
                 .expected = {{"camera_offset_s", -0.025}},
                 .source = "python: p[0] + p[1] * exposure_s"}},
  };
}

}  // namespace seam::effects
