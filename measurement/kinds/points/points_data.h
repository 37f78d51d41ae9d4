// The observations of a `points` set as read from its files.
#pragma once

#include <string>
#include <vector>

#include "measurement/problem/problem.h"
#include "measurement/sets/rig.h"
#include "measurement/sets/set.h"

namespace seam::measurement {

struct PointsData {
  Rig rig;
  CameraFacts camera;
  std::vector<double> stamp_s;  // By row, since the reference.
  std::vector<Vec3> p_W;
  std::vector<double> u_px, v_px;  // Observed; zero in a protocol without measured columns.
  std::vector<int> frame_of_row;
  std::vector<std::vector<int>> rows_of_frame;
};

// Reads and checks the table; fills what of the facts depends on it alone. `measured` false: a
// protocol, whose u_px and v_px need not exist.
PointsData read_points(const MeasurementSet& set, bool measured, Facts& facts);

// Lines of points that stand behind the camera with this model's joints and mount; none where the
// poses are unknown, since each is estimated such that it sees its points.
std::vector<int> lines_behind_camera(const Model& model, const MeasurementSet& set);

// Sets row, column, radius and the directions along it from the predicted places (observed less
// residual).
void place_covariates(const PointsData& data, const std::vector<double>& residual, Facts& facts);

// Covariates of points (docs/definitions.md, "What remains").
void add_points_covariates(const PointsData& data, const CsvTable& table, Facts& facts);

}  // namespace seam::measurement
