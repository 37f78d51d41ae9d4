// What a set of kind `ranges` holds: where the ball was put, and what was measured there.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "measurement/problem/problem.h"
#include "measurement/sets/set.h"

namespace seam::measurement {

// Where the ball was put, seen from the robot's place on the ground.
struct BallPlace {
  double true_m = 0;
  double bearing_rad = 0;  // Left positive.
  bool operator==(const BallPlace&) const = default;
};

// Measurements at one place on one side of the hold-out, as one observation.
struct RangeRow {
  size_t place = 0;
  int count = 0;
  double mean_m = 0;
  double spread_m = 0;   // Sample standard deviation; 0 with one measurement.
  double share = 1;      // Of the place's measurements.
  bool outlier = false;  // One measurement far from all others at its place, on a row of its own.
};

struct RangeData {
  std::vector<BallPlace> places;  // By distance, then bearing.
  std::vector<RangeRow> rows;
  // Groups of `Facts` that are held out together.
  std::vector<Groups> folds;
};

inline const std::vector<std::string> kRangeColumns = {"trial", "true_m", "measured_m",
                                                       "bearing_rad"};

// The place of each line of `ranges.csv`; `places` gets the distinct ones.
std::vector<size_t> read_places(const CsvTable& table, std::vector<BallPlace>& places);

// Fills all of `facts` but the channels.
RangeData read_ranges(const MeasurementSet& set, Facts& facts);

}  // namespace seam::measurement
