// The noise of points that a camera whose motion is known sees.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "measurement/kinds/points/board_field.h"
#include "measurement/kinds/points/points_noise.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"

namespace seam::measurement {
namespace {

// Residuals of the least-squares fit of y by the columns of A, scaled by 1 / sqrt(1 - leverage) so
// that each has the variance of the noise.
Eigen::VectorXd studentised(const Eigen::MatrixXd& A, const Eigen::VectorXd& y) {
  const Eigen::MatrixXd Q = column_basis(A);
  Eigen::VectorXd r = y - Q * (Q.transpose() * y);
  for (Eigen::Index i = 0; i < r.size(); ++i)
    r[i] /= std::sqrt(std::max(0.05, 1 - Q.row(i).squaredNorm()));
  return r;
}

}  // namespace

// Directions of the points in the frame of a camera that hangs on the logged joints, and whatever
// else may move the image: the joints' angles and rates, and time. As flexible as half of the
// points allow.
std::array<double, 2> estimate_noise_by_directions(const PointsData& data) {
  const Model none =
      Model::from_config(ConfigNode::from_text("format: seam-model/1\neffects: {}\n", "none"));
  const Rig::Motion motion = data.rig.motion(none);
  std::vector<std::vector<double>> direction(2);
  std::vector<std::vector<double>> state;
  for (size_t i = 0; i < data.p_W.size(); ++i) {
    const Vec3 p_C = motion.X_WC(data.stamp_s[i]).inverse() * data.p_W[i];
    const double depth = std::max(p_C.z, 0.05 * glm::length(p_C));
    direction[0].push_back(p_C.x / depth);
    direction[1].push_back(p_C.y / depth);
  }
  for (size_t j = 0; j < data.rig.joint_names().size(); ++j) {
    const auto& log = data.rig.logged(j);
    std::vector<double> angle, rate;
    for (const double t : data.stamp_s) angle.push_back(log.value(t)), rate.push_back(log.rate(t));
    state.insert(state.end(), {angle, rate});
  }
  state.push_back(data.stamp_s);
  std::erase_if(state, is_constant);
  for (auto* variables : {&direction, &state}) {
    for (auto& x : *variables) x = standardised(x);
  }
  const Eigen::MatrixXd A = smooth_columns(direction, state);
  std::array<double, 2> sigma{1, 1};
  for (int c = 0; c < 2; ++c) {
    const Eigen::VectorXd y =
        Eigen::Map<const Eigen::VectorXd>((c ? data.v_px : data.u_px).data(), A.rows());
    const Eigen::VectorXd r = studentised(A, y);
    sigma[c] = robust_sigma({r.begin(), r.end()});
  }
  return sigma;
}

}  // namespace seam::measurement
