// Kinds that estimate where a camera was, view by view, and what they find as a table.
#pragma once

#include <string>
#include <vector>

#include "effects/model.h"
#include "sim_core/base/pose.h"

namespace seam::measurement {

struct PlacedView {
  std::string name;
  int64_t time_ns = 0;  // Of the middle of its image's rows.
  Pose X_WC;
  // Standard errors of the attitude about the camera's axes, by the noise of the view's points.
  Vec3 sigma_rad{0.0};
  double exposure_s = 0;  // 0: not known.
};

class Problem;

class HasViews {
 public:
  virtual ~HasViews() = default;
  // In the order of time; views whose pose the model does not find are left out. Throws InputError
  // where poses are known, or have no times.
  virtual std::vector<PlacedView> placed_views(const effects::Model& model) const = 0;
};

// time_s,qw,qx,qy,qz,sigma_x_rad,sigma_y_rad,sigma_z_rad[,exposure_s],frame: what a set with an
// inertial sensor beside the camera takes. Throws InputError where the kind estimates no poses, or
// its views have no times of their own.
std::string attitudes_table(const Problem& problem, const effects::Model& model);

}  // namespace seam::measurement
