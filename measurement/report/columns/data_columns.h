// What was measured and commanded, by the rows of a problem: of this pictures of the data are made.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "measurement/problem/problem.h"
#include "measurement/sets/set.h"

namespace seam::measurement {

struct DataColumns {
  struct Place {
    std::string name;
    double x = 0, y = 0;  // m.
  };

  std::vector<std::pair<std::string, std::vector<double>>> columns;  // NaN: no value.
  std::map<std::string, std::vector<std::string>> names;  // Of columns that hold numbers of names.
  std::vector<Place> places;                              // Landmarks.

  const std::vector<double>& at(const std::string& name) const;
  std::string name(const std::string& column, int row) const;
};

// joints: track, time_s since the track's start, measured_rad, command_rad. odometry: track,
// time_s, x_m, y_m. landmarks: landmark, landmark_x_m, landmark_y_m, robot_x_m, robot_y_m.
// outcomes: scenario, value, statistic, measured, sigma. Other kinds: none.
DataColumns data_columns(const Problem& problem, const MeasurementSet& set);

}  // namespace seam::measurement
