// What a robot senses besides its camera.
#pragma once

#include <array>

#include "sim_core/joints.h"
#include "sim_core/scenario.h"
#include "sim_core/time.h"

namespace seam {

// Each part was taken at its own instant, by its own clock, and is delivered after its latency.
struct SensorReading {
  SimTime time;  // When this reading was asked for.

  SimTime joints_time;
  JointAngles joints_rad{};  // Encoders.

  SimTime odometry_time;
  Pose2 odometry;  // Dead reckoning since the start, in the frame of the first pose.

  SimTime accelerometer_time;
  Vec3 acceleration_B_mps2{0.0};  // Specific force in the body's frame: +9.81 in z at rest.

  SimTime paws_time;
  std::array<bool, kLegs> paw_contact{};
};

}  // namespace seam
