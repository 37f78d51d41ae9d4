// From a model and a set of points to where each point is seen.
#pragma once

#include "effects/stages/geometry.h"
#include "effects/stages/timing.h"
#include "measurement/kinds/points/points_data.h"

namespace seam::measurement {

struct MeasureOptions;

// Where effects of the target put the point of each row; `displaced_m` are the points' own
// displacements along the target's axes (empty: none).
std::vector<Vec3> places_of_rows(const PointsData& data, const effects::TargetShape& shape,
                                 const std::vector<Vec3>& displaced_m = {});

// A model compiled for one set: stamps to instants, instants to poses, poses to image points.
class PointsPredictor {
 public:
  PointsPredictor(const PointsData& data, const Model& model)
      : data_(data),
        places_W_(places_of_rows(data, effects::target_of(model))),
        timing_(effects::timing_of(model)),
        motion_(data.rig.motion(model)),
        projection_(model, data.camera.width_px, data.camera.height_px) {}

  // Seconds since the reference at which the frame's row is seen.
  double instant(double stamp_s, double row) const {
    return timing_.in_lock(stamp_s, data_.rig.cycle_s()) +
           timing_.row_middle_after_stamp_s(row, stamp_s);
  }

  // `late_s` and `joint_errors` are small changes for derivatives.
  effects::ImagePoint image(size_t row, double late_s = 0,
                            const double* joint_errors = nullptr) const {
    return image_at(row, places_W_[row], late_s, joint_errors);
  }
  // The same with the row's point elsewhere.
  effects::ImagePoint image_at(size_t row, const Vec3& p_W, double late_s = 0,
                               const double* joint_errors = nullptr) const;

  const std::vector<Vec3>& places_W() const { return places_W_; }
  const effects::Timing& timing() const { return timing_; }
  const Rig::Motion& motion() const { return motion_; }
  const effects::Projection& projection() const { return projection_; }

 private:
  const PointsData& data_;
  std::vector<Vec3> places_W_;  // By row.
  effects::Timing timing_;
  Rig::Motion motion_;
  effects::Projection projection_;
};

// `seam measure` for this kind (points_measure.cc).
void measure_points(const Model& truth, const MeasurementSet& protocol,
                    const MeasureOptions& options);

}  // namespace seam::measurement
