// A set of kind `landmarks` as it is read: where the robot was, where landmarks are, what was seen.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "effects/row_columns.h"
#include "measurement/kinds/kinds.h"
#include "measurement/sets/spline.h"

namespace seam::measurement {

struct PlanePose {
  double x_m, y_m, theta_rad;
  double z_m = 0;
};

// One run's measured poses.
struct Walk {
  Spline x, y, theta;       // Heading unwrapped.
  std::optional<Spline> z;  // Of the robot's origin; none: it stays at z = 0.

  PlanePose at(double t_s) const {
    return {x.value(t_s), y.value(t_s), theta.value(t_s), z ? z->value(t_s) : 0};
  }
};

inline constexpr std::array<const char*, 2> kLandmarkColumns = {"range_m", "bearing_rad"};

struct LandmarkData {
  std::vector<Walk> walks;
  std::vector<int> walk_of_row;
  std::vector<double> stamp_s;                             // Since the first time of the poses.
  std::vector<double> landmark_x, landmark_y, landmark_z;  // By row.
  bool heights = false;  // Whether those of landmarks are known; else all lies in a plane.
  std::vector<int> landmark_of_row;
  std::vector<std::string> landmarks;        // Their names.
  std::vector<double> range_m, bearing_rad;  // NaN where blank.
  // Scalars exist only where something was measured: by row those of its range and its bearing, and
  // which channels these are; -1: none.
  std::vector<std::array<int, 2>> scalars;
  std::array<int, 2> channels = {-1, -1};
  effects::FurtherColumns further;              // Of the table.
  std::vector<std::vector<int>> rows_of_frame;  // Seen at the same stamp of the same run.
};

// Reads and checks the set's tables; fills everything in `facts` but the channels. `measured`
// false: a protocol, ranges and bearings are not read.
LandmarkData read_landmarks(const MeasurementSet& set, bool measured, Facts& facts);

}  // namespace seam::measurement
