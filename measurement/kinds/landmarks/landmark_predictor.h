// From a model and a set of landmarks to what the robot's detector reports.
#pragma once

#include <array>
#include <cmath>

#include "effects/stages/detector.h"
#include "effects/stages/geometry.h"
#include "effects/stages/timing.h"
#include "measurement/kinds/landmarks/landmark_data.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {

// A model compiled for one set.
class LandmarkPredictor {
 public:
  LandmarkPredictor(const LandmarkData& data, const Model& model)
      : data_(data), timing_(effects::timing_of(model)), X_LC_(effects::mount_of(model)) {
    for (const effects::ModelEffect& effect : model.effects()) {
      if (!effect.definition->detector) continue;
      spreads_last_ = spreads_last_ && (effect.definition->spread_only || !has_spreads_);
      has_spreads_ = has_spreads_ || effect.definition->spread_only;
      has_formulas_ = has_formulas_ || !effect.definition->source.empty();
      detectors_.push_back(effect);
    }
    // Bearings are angles in the plane: of the mount's rotation only the yaw matters. The camera
    // looks along its z, which is the link's x.
    yaw_rad_ = std::atan2(X_LC_.R[2].y, X_LC_.R[2].x);
  }

  // `moved_m`: the landmark lies so far from its place in the map.
  effects::Detection detect(size_t row, double late_s = 0,
                            std::array<double, 2> moved_m = {0, 0}) const {
    const double stamp = data_.stamp_s[row];
    const double t = stamp + timing_.row_middle_after_stamp_s(0, stamp) + late_s;
    const PlanePose pose = data_.walks[data_.walk_of_row[row]].at(t);
    const double dx = data_.landmark_x[row] + moved_m[0] - pose.x_m,
                 dy = data_.landmark_y[row] + moved_m[1] - pose.y_m;
    const double c = std::cos(pose.theta_rad), s = std::sin(pose.theta_rad);
    const double ahead = c * dx + s * dy - X_LC_.p.x;
    const double left = -s * dx + c * dy - X_LC_.p.y;
    const double above = data_.heights ? data_.landmark_z[row] - pose.z_m - X_LC_.p.z : 0;
    effects::Detection seen{.range_m = std::hypot(std::hypot(ahead, left), above),
                            .bearing_rad = maths::wrap_angle(std::atan2(left, ahead) - yaw_rad_),
                            .above_m = above,
                            .x_m = pose.x_m + c * X_LC_.p.x - s * X_LC_.p.y,
                            .y_m = pose.y_m + s * X_LC_.p.x + c * X_LC_.p.y,
                            .t_s = t,
                            .columns = {data_.further, row}};
    if (has_formulas_) {
      const Walk& walk = data_.walks[data_.walk_of_row[row]];
      seen.speed_mps = c * walk.x.rate(t) + s * walk.y.rate(t);
      seen.turn_radps = walk.theta.rate(t);
    }
    for (const effects::ModelEffect& effect : detectors_)
      effect.definition->detector(effect.values(), seen);
    return seen;
  }

  // By how much range and bearing, the two rows, grow with x and y of the row's landmark.
  std::array<std::array<double, 2>, 2> slopes_by_place(size_t row) const {
    constexpr double kStep_m = 1e-4;
    std::array<std::array<double, 2>, 2> slopes;
    for (size_t axis = 0; axis < 2; ++axis) {
      const double x = axis == 0 ? kStep_m : 0, y = axis == 1 ? kStep_m : 0;
      const effects::Detection less = detect(row, 0, {-x, -y}), more = detect(row, 0, {x, y});
      slopes[0][axis] = (more.range_m - less.range_m) / (2 * kStep_m);
      slopes[1][axis] =
          std::remainder(more.bearing_rad - less.bearing_rad, 2 * maths::kPi) / (2 * kStep_m);
    }
    return slopes;
  }

  // Whether no detector changes what one of spread has looked at, so that spread_about holds.
  bool spreads_last() const { return spreads_last_; }
  // Variances of what detect gave, or would give, as the mean of a row.
  effects::Detection spread_about(effects::Detection seen) const {
    seen.range_variance = seen.bearing_variance = 0;
    for (const effects::ModelEffect& effect : detectors_) {
      if (effect.definition->spread_only) effect.definition->detector(effect.values(), seen);
    }
    return seen;
  }

  const effects::Timing& timing() const { return timing_; }

 private:
  const LandmarkData& data_;
  effects::Timing timing_;
  Pose X_LC_;
  double yaw_rad_ = 0;
  std::vector<effects::ModelEffect> detectors_;
  bool spreads_last_ = true, has_spreads_ = false;
  bool has_formulas_ = false;  // Which alone read how the robot moves.
};

// `seam measure` for this kind (landmarks_measure.cc).
void measure_landmarks(const Model& truth, const MeasurementSet& protocol,
                       const MeasureOptions& options);

}  // namespace seam::measurement
