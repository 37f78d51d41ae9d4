#include "measurement/kinds/points/points_noise.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "measurement/kinds/points/board_field.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"

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

std::array<double, 2> noise_by_frames(const PointsData& data, const std::vector<char>& gross) {
  std::array<std::vector<double>, 2> left;
  for (const std::vector<int>& all : data.rows_of_frame) {
    std::vector<int> rows;
    std::copy_if(all.begin(), all.end(), std::back_inserter(rows),
                 [&](int row) { return gross.empty() || !gross[2 * row]; });
    if (rows.empty()) continue;
    const BoardField field(data, rows);
    if (field.along().empty()) continue;
    // As flexible as half of the frame's points allow, at most of degree 8.
    int degree = 8;
    while (degree > 1 && static_cast<size_t>(field.columns(degree).cols()) * 2 > rows.size())
      --degree;
    const Eigen::MatrixXd A = field.columns(degree);
    if (static_cast<size_t>(A.cols()) + 4 > rows.size()) continue;
    for (int c = 0; c < 2; ++c) {
      Eigen::VectorXd y(rows.size());
      for (size_t i = 0; i < rows.size(); ++i) y[i] = (c ? data.v_px : data.u_px)[rows[i]];
      const Eigen::VectorXd r = studentised(A, y);
      for (size_t i = 0; i < rows.size(); ++i)
        left[c].push_back(r[i] / (data.spread.empty() ? 1 : data.spread[rows[i]]));
    }
  }
  if (left[0].empty())
    throw InputError(
        "measurement.yaml: noise: found none, and no view has points enough to estimate it from "
        "(7 or more), expected for example {u_px: 0.2, v_px: 0.2}");
  return {robust_sigma(left[0]), robust_sigma(left[1])};
}

// Degrees of the polynomials: of the direction alone, of the state alone, and of both in their
// products.
struct Degrees {
  int field, state, field_of_products, state_of_products;
};
constexpr Degrees kDegrees[] = {{7, 3, 3, 2}, {7, 3, 3, 1}, {5, 2, 2, 1}, {4, 1, 1, 1},
                                {3, 1, 0, 0}, {2, 0, 0, 0}, {1, 0, 0, 0}};

// What is smooth in where a point is seen and how the head moves then.
Eigen::MatrixXd smooth_columns(const std::vector<std::vector<double>>& direction,
                               const std::vector<std::vector<double>>& state,
                               const Degrees& degrees) {
  const auto but_constant = [](const Eigen::MatrixXd& all) {
    return Eigen::MatrixXd(all.rightCols(all.cols() - 1));
  };
  const Eigen::MatrixXd field = monomials(direction, degrees.field);
  if (state.empty()) return field;
  const Eigen::MatrixXd alone = but_constant(monomials(state, degrees.state));
  const Eigen::MatrixXd a = but_constant(monomials(direction, degrees.field_of_products));
  const Eigen::MatrixXd b = but_constant(monomials(state, degrees.state_of_products));
  Eigen::MatrixXd all(field.rows(), field.cols() + alone.cols() + a.cols() * b.cols());
  all << field, alone, Eigen::MatrixXd(field.rows(), a.cols() * b.cols());
  Eigen::Index at = field.cols() + alone.cols();
  for (Eigen::Index m = 0; m < b.cols(); ++m) {
    for (Eigen::Index k = 0; k < a.cols(); ++k) all.col(at++) = b.col(m).cwiseProduct(a.col(k));
  }
  return all;
}

// Directions of the points in the frame of a camera that hangs on the logged joints, and whatever
// else may move the image: the joints' angles and rates, and time. As flexible as half of the
// points allow.
std::array<double, 2> noise_by_directions(const PointsData& data) {
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
  Eigen::MatrixXd A;
  for (const Degrees& degrees : kDegrees) {
    A = smooth_columns(direction, state, degrees);
    if (2 * A.cols() <= A.rows()) break;
  }
  std::array<double, 2> sigma{1, 1};
  for (int c = 0; c < 2; ++c) {
    const Eigen::VectorXd y =
        Eigen::Map<const Eigen::VectorXd>((c ? data.v_px : data.u_px).data(), A.rows());
    const Eigen::VectorXd r = studentised(A, y);
    sigma[c] = robust_sigma({r.begin(), r.end()});
  }
  return sigma;
}

}  // namespace

std::array<double, 2> estimate_points_noise(const PointsData& data,
                                            const std::vector<char>& gross) {
  return data.rig.type() == Rig::Type::unknown ? noise_by_frames(data, gross)
                                               : noise_by_directions(data);
}

}  // namespace seam::measurement
