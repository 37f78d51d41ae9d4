// Controls of a path fitted to all points of its frames.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "measurement/kinds/points/motion/path_sight.h"

namespace seam::measurement {

class PathAdjustment {
 public:
  PathAdjustment(const PathLayout& layout, std::vector<PathSighting> seen)
      : layout_(layout), seen_(std::move(seen)) {}

  // Goes down to the best controls; false where a point has no image.
  bool fit(const RowCamera& camera, std::vector<Control>& controls) const;
  // Where a point is seen; false: nowhere.
  bool image(const RowCamera& camera, const std::vector<Control>& controls,
             const PathSighting& point, Eigen::Vector2d& uv) const {
    return image_on_path(layout_, camera, controls, point, uv);
  }
  // Takes from columns over the residuals (u, v of each sighting in turn, over their sigmas) what
  // the path can follow. `counted` (empty: as they are) holds for each sighting what its residuals
  // count by, of which both columns and path are made first.
  bool take_out_path(const RowCamera& camera, const std::vector<Control>& controls,
                     const std::vector<Eigen::Matrix2d>& counted, Eigen::MatrixXd& columns) const;

  // Half the sum of squares of residuals over their sigmas.
  double cost(const RowCamera& camera, const std::vector<Control>& controls) const;
  const std::vector<PathSighting>& seen() const { return seen_; }

 private:
  bool looks(const RowCamera& camera, const std::vector<Control>& controls,
             std::vector<PathLook>& all) const;
  static double cost_of(const std::vector<PathLook>& all);

  const PathLayout& layout_;
  std::vector<PathSighting> seen_;
};

}  // namespace seam::measurement
