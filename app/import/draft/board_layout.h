// Corners of a flat target and the plane that they lie in.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "app/import/draft/points_draft.h"

namespace seam::app {

bool is_flat(const SeenView& view);

// The homography from a flat target's plane (its origin and size those of these corners) to
// ((u - centre_u) / scale, (v - centre_v) / scale), and the root mean square of its equations'
// residuals: in units of `scale`, about the corners' distances from it.
struct PlaneMap {
  Eigen::Matrix3d map;
  double misfit = 0;
};
PlaneMap plane_map(const std::vector<SeenCorner>& corners, double centre_u_px, double centre_v_px,
                   double scale_px);

// Throws InputError where the corners fit a board with columns and rows exchanged, and not the one
// that is stated: as many corners, each at another's place.
void check_layout(const std::vector<SeenView>& views, const std::string& file);

}  // namespace seam::app
