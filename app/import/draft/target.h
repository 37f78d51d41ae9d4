// Calibration targets: their points, and what a detector has to know of them.
#pragma once

#include <string>
#include <vector>

#include "app/import/draft/request.h"
#include "sim_core/base/config.h"
#include "sim_core/base/pose.h"

namespace seam::app {

struct TargetSpec {
  std::string pattern;        // chessboard, circles, asymmetric_circles, aprilgrid or charuco.
  int columns = 0, rows = 0;  // Inner corners, circles, tags, or squares of a ChArUco board.
  std::vector<Vec3> points;   // By their numbers, row by row.
  double marker_ratio = 0;    // Of ChArUco: a marker's side over a square's.
  int dictionary = 0;         // Of ChArUco: the number that OpenCV gives it.
};

// A file like Kalibr's: target_type aprilgrid, checkerboard or circlegrid; here also charuco, with
// squareCols, squareRows, squareSize, markerSize and dictionary.
TargetSpec read_target(const ConfigNode& root, const ImportRequest& request);

// By --target, --board and --spacing; throws UsageError where the user did not say all of it.
TargetSpec stated_target(const ImportRequest& request);

}  // namespace seam::app
