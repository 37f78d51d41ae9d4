// Turns of a camera from view to view, and what a gyroscope on the same body makes of them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "measurement/gyro/gyroscope.h"
#include "sim_core/base/pose.h"

namespace seam::measurement {

// Views are compared at the sensor's times; an offset may be as large as this, s.
inline constexpr double kMostOffset_s = 0.5;

struct AttitudeView {
  int line = 0;        // In its table.
  double at_s = 0;     // Since the sensor's first sample, by the camera's clock.
  Mat3 R_WC{1.0};      // From the camera's axes to those of the world.
  Vec3 variance{0.0};  // Of its attitude, about the camera's axes, rad^2.
  double exposure_s = 0;
};

// From one view to the next one.
struct CameraTurn {
  size_t from = 0, to = 0;  // Of the views.
  Vec3 turn_rad{0.0};       // In the camera's axes.
  // What errors of both attitudes, about the camera's axes then, make of it.
  Eigen::Matrix3d by_to, by_from;  // The second with the sign turned about.
};

// The gyroscope and the views beside it.
struct CameraData : Gyroscope {
  std::vector<AttitudeView> views;
  std::vector<CameraTurn> turns;  // In the order of time, those that the gyroscope covers.
  bool knows_exposure = false;    // And it differs from view to view.
  size_t left = 0;                // Views that are in no turn.
};

// Reads and checks imu.csv and attitudes.csv.
CameraData read_camera(const MeasurementSet& set);

}  // namespace seam::measurement
