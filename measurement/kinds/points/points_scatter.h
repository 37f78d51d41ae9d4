// Points whose detection failed: a fraction of them has a further error, in u and in v at once.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "measurement/kinds/points/target/pose_solver.h"
#include "measurement/noise/few_errors.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {

// Of a model; nothing where no point fails.
std::optional<FewErrors> scatter_of(const Model& model);

// Whitens these scalars, u before v of a point, as whiten_diagonal has left them. Column k of
// `causes` is what cause k, which they share, does to each at one sigma; there may be none.
void whiten_scattered(const FewErrors& scatter, const std::vector<size_t>& scalars,
                      const Eigen::MatrixXd& causes, const Facts& facts, Evaluation& evaluation);

// A point whose detector may have failed: how likely that is, and the sigmas with which its
// residuals u and v count (of the precision that the point would have, what is left on average).
struct Failure {
  double share = 0;
  double sigma_u = 0, sigma_v = 0;
};
Failure failure_of(const FewErrors& scatter, double u, double v, double sigma_u, double sigma_v);

// Refines a pose under such errors: points that seem to have failed count less (expectation and
// maximisation in turn). False where it fails.
bool refine_scattered_pose(const FewErrors& scatter, const Cameras& cameras,
                           std::vector<Sighting> seen, bool near, Pose& X_CW);

}  // namespace seam::measurement
