// From a model and a set of points to where each point is seen.
#pragma once

#include "effects/stages/geometry.h"
#include "effects/stages/timing.h"
#include "measurement/kinds/points/data/points_data.h"

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
      : data_(data), places_W_(places_of_rows(data, effects::target_of(model))) {
    for (const CameraView& view : data.cameras) {
      const Model own = model_of(model, view.name);
      eyes_.push_back(
          {effects::timing_of(own), data.rig.motion(own),
           effects::Projection(own, view.width_px, view.height_px, effects::Reaches::detector)});
    }
  }

  // Seconds since the reference at which the image row `v` of a row's frame is seen.
  double instant(size_t row, double v) const {
    const effects::Timing& timing = eyes_[static_cast<size_t>(data_.camera_of_row[row])].timing;
    const double stamp_s = data_.stamp_s[row];
    const double exposure_s = data_.exposure_s.empty() ? 0 : data_.exposure_s[row];
    return timing.in_lock(stamp_s, data_.rig.cycle_s()) +
           timing.row_middle_after_stamp_s(v, stamp_s) + timing.per_exposure * exposure_s;
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
  // Of the first camera; what is random of them is the same for all.
  const effects::Timing& timing() const { return eyes_.front().timing; }
  const Rig::Motion& motion() const { return eyes_.front().motion; }

 private:
  struct Eye {
    effects::Timing timing;
    Rig::Motion motion;
    effects::Projection projection;
  };
  const PointsData& data_;
  std::vector<Vec3> places_W_;  // By row.
  std::vector<Eye> eyes_;       // By camera.
};

// `seam measure` for this kind (points_measure.cc).
void measure_points(const Model& truth, const MeasurementSet& protocol,
                    const MeasureOptions& options);

}  // namespace seam::measurement
