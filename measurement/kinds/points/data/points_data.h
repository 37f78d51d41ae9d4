// The observations of a `points` set as read from its files.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "measurement/gyro/gyroscope.h"
#include "measurement/kinds/points/target/cameras.h"
#include "measurement/kinds/points/target/target_frame.h"
#include "measurement/problem/problem.h"
#include "measurement/sets/rig.h"
#include "measurement/sets/set.h"

namespace seam::measurement {

struct PointsData {
  Rig rig;
  CameraFacts camera;
  std::vector<CameraView> cameras;  // One, without a name, where the table has no such column.
  std::vector<int> camera_of_row;
  std::vector<double> stamp_s;     // By row, since the reference.
  std::vector<double> exposure_s;  // By row, of its frame. Empty: the table has none.
  std::shared_ptr<const GyroscopeBeside> gyroscope;  // Null: there is none.
  std::vector<Vec3> p_W;                             // By the set's plan.
  Target target;
  std::vector<int> point_of_row;
  std::vector<double> u_px, v_px;  // Observed; zero in a protocol without measured columns.
  // By row: its noise over that of the channel (1 / sqrt(weight)); 0 takes no part. Empty: all 1.
  std::vector<double> spread;
  std::vector<double> spread_of_view;  // What of it is estimated, by view. Empty: nothing.
  double sigma_px = 0;  // Of the channel where the rows state their own; 0: they do not.
  std::vector<int> frame_of_row;
  std::vector<std::string> frames;  // Their names.
  std::vector<std::vector<int>> rows_of_frame;
  // What one camera sees in one frame.
  std::vector<std::vector<int>> rows_of_view;
  std::vector<int> view_of_row;
  effects::FurtherColumns further;  // Of the table, and the logged angles of the joints.
  effects::RowColumns columns_of(size_t row) const { return {further, row}; }

  // When in its image's time this point's row is read: -1/2 at the first row, 1/2 at the last.
  double part_read(size_t row) const {
    return v_px[row] / cameras[static_cast<size_t>(camera_of_row[row])].height_px - 0.5;
  }
};

// Reads and checks the table; fills what of the facts depends on it alone. `measured` false: a
// protocol, whose u_px and v_px need not exist.
PointsData read_points(const MeasurementSet& set, bool measured, Facts& facts);
// The same beside this rig, whatever the set says of its own.
PointsData read_points(const MeasurementSet& set, Rig rig, bool measured, Facts& facts);

// Lines of points that stand behind the camera with this model's joints and mount; none where the
// poses are unknown, since each is estimated such that it sees its points.
std::vector<int> lines_behind_camera(const Model& model, const MeasurementSet& set);

// Sets row, column, radius and the directions along it from the predicted places (observed less
// residual).
void place_covariates(const PointsData& data, const std::vector<double>& residual, Facts& facts);

// Covariates of points (docs/reference/definitions.md, "What remains").
void add_points_covariates(const PointsData& data, Facts& facts);

}  // namespace seam::measurement
