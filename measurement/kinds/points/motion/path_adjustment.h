// Controls of a path fitted to all points of its frames. Each point is seen when its own row is
// read out, so that the row depends on the path and the path's instant on the row.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "measurement/kinds/points/motion/path.h"
#include "measurement/kinds/points/target/cameras.h"

namespace seam::measurement {

// One point in one frame.
struct PathSighting {
  size_t row = 0, frame = 0;
  Vec3 p_T{0.0};  // From the target's middle, along the world's axes.
  double u_px = 0, v_px = 0;
  double sigma_u = 1, sigma_v = 1;
  double stamp_s = 0;
  int camera = 0;
};

// The time from one row's exposure to the next one's, and by how much the first one is later than
// that of the first camera with the same stamp.
struct RowClock {
  double line_delay_s = 0, late_s = 0;
};

struct RowCamera {
  Cameras cameras;
  std::vector<RowClock> clocks;  // By camera.
};

class PathAdjustment {
 public:
  PathAdjustment(const PathLayout& layout, std::vector<PathSighting> seen)
      : layout_(layout), seen_(std::move(seen)) {}

  // Goes down to the best controls; false where a point has no image.
  bool fit(const RowCamera& camera, std::vector<Control>& controls) const;
  // Where a point is seen; false: nowhere.
  bool image(const RowCamera& camera, const std::vector<Control>& controls,
             const PathSighting& point, Eigen::Vector2d& uv) const;
  // Takes from columns over the residuals (u, v of each sighting in turn, over their sigmas) what
  // the path can follow. `counted` (empty: as they are) holds for each sighting what its residuals
  // count by, of which both columns and path are made first.
  bool take_out_path(const RowCamera& camera, const std::vector<Control>& controls,
                     const std::vector<Eigen::Matrix2d>& counted, Eigen::MatrixXd& columns) const;

  // Half the sum of squares of residuals over their sigmas.
  double cost(const RowCamera& camera, const std::vector<Control>& controls) const;
  const std::vector<PathSighting>& seen() const { return seen_; }

 private:
  // One point's residuals over their sigmas, and their derivatives by the controls that act.
  struct Look {
    ControlWeights weights;
    Eigen::Vector2d z;
    Eigen::Matrix<double, 2, 24> slopes;
  };
  bool look(const RowCamera& camera, const std::vector<Control>& controls,
            const PathSighting& point, Look& look) const;
  bool looks(const RowCamera& camera, const std::vector<Control>& controls,
             std::vector<Look>& all) const;
  static double cost_of(const std::vector<Look>& all);

  const PathLayout& layout_;
  std::vector<PathSighting> seen_;
};

}  // namespace seam::measurement
