// A target whose points lie farther apart, or nearer, than its plan says: a wrong spacing. Where
// the camera's poses are known, from a robot or from motion capture, the pictures tell; where each
// view's pose is estimated they cannot, since all distances grow alike.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "sim_core/base/pose.h"

namespace seam::measurement {

using ImagePlace = std::array<double, 2>;  // u, v.

struct WrongSpacing {
  double factor = 1;       // How many times as far apart the points are.
  double neighbour_m = 0;  // Between nearest points of the plan, the usual distance.
  // What stays of the residuals, root mean square: of the plan shifted to where it fits best, and
  // of it drawn out as well.
  double before_px = 0, after_px = 0;
};

// `places` by observation, by the plan; `seen` what was observed; `image` where a point at a place
// comes in the picture of that observation (nothing: behind the camera). A factor is told where the
// residuals fall to a third by it, and where neither a shift of the target nor another focal length
// does about as much.
std::optional<WrongSpacing> wrong_spacing(
    const std::vector<Vec3>& places, const std::vector<ImagePlace>& seen,
    const std::function<std::optional<ImagePlace>(size_t, const Vec3&)>& image);

}  // namespace seam::measurement
