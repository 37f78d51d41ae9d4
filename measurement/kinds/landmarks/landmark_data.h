// A set of kind `landmarks` as it is read: where the robot was, where landmarks are, what was seen.
#pragma once

#include <string>
#include <vector>

#include "measurement/kinds/kinds.h"
#include "measurement/sets/spline.h"

namespace seam::measurement {

struct PlanePose {
  double x_m, y_m, theta_rad;
};

// One run's measured poses.
struct Walk {
  Spline x, y, theta;  // Heading unwrapped.

  PlanePose at(double t_s) const { return {x.value(t_s), y.value(t_s), theta.value(t_s)}; }
};

struct LandmarkData {
  std::vector<Walk> walks;
  std::vector<int> walk_of_row;
  std::vector<double> stamp_s;                 // Since the first time of the poses.
  std::vector<double> landmark_x, landmark_y;  // By row.
  std::vector<int> landmark_of_row;
  std::vector<double> range_m, bearing_rad;
  std::vector<std::vector<int>> rows_of_frame;  // Seen at the same stamp of the same run.
};

// Reads and checks the set's tables; fills everything in `facts` but the channels. `measured`
// false: a protocol, ranges and bearings are not read.
LandmarkData read_landmarks(const MeasurementSet& set, bool measured, Facts& facts);

}  // namespace seam::measurement
