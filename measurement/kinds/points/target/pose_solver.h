// The pose of a camera from the image positions of known points, when nobody measured it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "measurement/kinds/points/target/cameras.h"
#include "sim_core/base/pose.h"

namespace seam::measurement {

struct Sighting {
  Vec3 p_W{0.0};
  double u_px = 0, v_px = 0;
  double sigma_u = 1, sigma_v = 1;
  double t_s = 0;
  int camera = 0;
  effects::RowColumns columns;
};

// X_CW from what is linear: a homography of the points projected on their plane where they lie in
// one or nearly so, a direct linear transform where they do not. Where several starts are possible
// (a board seen from far looks alike tilted one way and the other) each is refined with all points
// and the one that sees them best is taken. Nothing where fewer than 4 (6 out of a plane) rays
// exist. Of several cameras the one that sees most says where it stands.
bool initial_pose(const Cameras& cameras, const std::vector<Sighting>& seen, Pose& X_CW);

// Minimises the squared whitened residuals over the pose, from X_CW, with Levenberg-Marquardt.
// False where a point has no image.
bool refine_pose(const Cameras& cameras, const std::vector<Sighting>& seen, Pose& X_CW);

// Whitened residuals (u, v in turn) and, if wanted, their derivatives by the pose's six parameters
// (rotation about C's axes, then shift), row-major 2n x 6.
bool pose_residuals(const Cameras& cameras, const std::vector<Sighting>& seen, const Pose& X_CW,
                    std::vector<double>& residuals, std::vector<double>* derivatives);

// A pose turned about C's axes by the first three numbers and shifted by the last three.
Pose moved_pose(const Pose& X_CW, const Eigen::Matrix<double, 6, 1>& step);

// Poses among the nuisances of an evaluation: 12 numbers a frame. False where none is stored.
bool stored_pose(const std::vector<double>& values, size_t frame, Pose& X_CW);
void store_pose(const Pose& X_CW, size_t frame, std::vector<double>& values);

}  // namespace seam::measurement
