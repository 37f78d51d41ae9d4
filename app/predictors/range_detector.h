// The SDK's ball detector, on a standing robot, as measurement sets of kind `ranges` need it.
#pragma once

#include <string>
#include <vector>

#include "measurement/imaging/instruments.h"

namespace seam::app {

// Where a head looks to see a ball at this distance on the ground from the robot's place, as the
// founding paper's Fig. 10 shows: the camera is about 0.23 m high. To 1e-4 rad, as a command line
// gives it.
double tilt_to_ball_rad(double distance_m);

measurement::MakeRangeDetector sdk_detectors();
std::vector<std::string> sdk_detector_names();

}  // namespace seam::app
