// The target of a set of points: which points it has, and the plane and axes of a board.
#pragma once

#include <string>
#include <vector>

#include "effects/stages/target.h"
#include "sim_core/base/pose.h"

namespace seam::measurement {

struct Target {
  std::vector<std::string> names;  // Of its points.
  std::vector<Vec3> plan_W;        // Where the set says that they are.
  std::vector<size_t> views;       // In how many images each is seen.
  // Axes along the board and out of its plane as columns, and its middle. What lies in no plane has
  // the world's axes.
  Mat3 axes_W{1.0};
  Vec3 middle_W{0.0};
  double half_x_m = 1, half_y_m = 1;  // From the middle to the outermost points.
  bool flat = false;

  // The point of this number where effects of the target put it, without its own displacement.
  Vec3 placed_W(size_t point, const effects::TargetShape& shape) const;
  // By how much a bending of a view moves the point along z, for each metre.
  double bending(size_t point, const effects::TargetShape& shape) const;
  // The point's plan from the middle, along the axes.
  Vec3 in_axes(size_t point) const;
};

// The plane through points: columns along it and out of it, and whether they lie in it but for a
// small height against their extent. Points in a line, or too few, have none.
struct Plane {
  Mat3 axes{1.0};
  Vec3 middle{0.0};
  double height_share = 1;  // Height against the smaller extent, root mean squares.
  bool exists = false;
};
Plane plane_through(const std::vector<Vec3>& points);
// Points this flat are a board.
inline constexpr double kBoardHeight = 0.05;

// `point_of_row`: numbers in `names`; a point has the place of its first row.
Target target_of_rows(const std::vector<std::string>& names, const std::vector<int>& point_of_row,
                      const std::vector<Vec3>& p_W, const std::vector<int>& frame_of_row);

}  // namespace seam::measurement
