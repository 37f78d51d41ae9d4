// The pose of a camera from the image positions of known points, when nobody measured it.
#pragma once

#include <vector>

#include "effects/stages/geometry.h"
#include "sim_core/base/pose.h"

namespace seam::measurement {

struct Sighting {
  Vec3 p_W{0.0};
  double u_px = 0, v_px = 0;
  double sigma_u = 1, sigma_v = 1;
  double t_s = 0;
};

// X_CW from a homography (points in a plane) or a direct linear transform; nothing where fewer
// than 4 (6 out of a plane) rays exist.
bool initial_pose(const effects::Projection& projection, const std::vector<Sighting>& seen,
                  Pose& X_CW);

// Minimises the squared whitened residuals over the pose, from X_CW, with Levenberg-Marquardt.
// False where a point has no image.
bool refine_pose(const effects::Projection& projection, const std::vector<Sighting>& seen,
                 Pose& X_CW);

// Whitened residuals (u, v in turn) and, if wanted, their derivatives by the pose's six parameters
// (rotation about C's axes, then shift), row-major 2n x 6.
bool pose_residuals(const effects::Projection& projection, const std::vector<Sighting>& seen,
                    const Pose& X_CW, std::vector<double>& residuals,
                    std::vector<double>* derivatives);

}  // namespace seam::measurement
