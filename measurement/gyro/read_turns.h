// How a camera turns while the rows of an image are read, by a gyroscope on the same body.
#pragma once

#include "effects/model.h"
#include "measurement/gyro/gyroscope.h"

namespace seam::measurement {

// Where the sensor's clock and its axes are beside the camera's, the model says (camera_imu_offset,
// camera_imu_rotation), and what its readings have wrong (gyro_bias and others).
class ReadTurns {
 public:
  // Refers to the readings.
  ReadTurns(const GyroscopeBeside& beside, const effects::Model& model);

  // Vectors in the camera's axes at the first time, in those at the second.
  Mat3 between(double from_s, double to_s, double exposure_s) const;
  // Of what is at rest, as it turns about the camera: radians a second in the camera's axes.
  Vec3 rate(double at_s, double exposure_s) const;

 private:
  double sensor_s(double at_s, double exposure_s) const;

  effects::Inertial inertial_;
  GyroPath path_;
  double first_s_ = 0;
  Mat3 R_IC_;  // From the camera's axes to the sensor's.
};

}  // namespace seam::measurement
