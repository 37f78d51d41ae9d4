// Points seen by a camera whose motion is known: a chain of joints, or measured poses.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "measurement/kinds/points/data/board_field.h"
#include "measurement/kinds/points/data/points_noise.h"
#include "measurement/kinds/points/points_predictor.h"
#include "measurement/kinds/points/points_problem.h"
#include "measurement/noise/low_rank.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"

namespace seam::measurement {

bool PointsProblem::has_shared_causes(const PointsPredictor& predictor) const {
  return predictor.timing().jitter_sigma_s > 0 || predictor.motion().quantisation_step_rad > 0;
}

Evaluation PointsProblem::evaluate_rig(const Model& model, const Groups& groups,
                                       const Evaluation* warm) const {
  Evaluation evaluation = blank();
  evaluation.mean_key = mean_parameters(model);
  const bool reuse = warm && warm->valid && warm->mean_key == evaluation.mean_key;
  const PointsPredictor predictor(data_, model);
  if (reuse) evaluation.residual = warm->residual;
  for (size_t row = 0; row < data_.p_W.size() && !reuse; ++row) {
    if (!groups[facts_.group_of_row[row]]) continue;
    const effects::ImagePoint point = predictor.image(row);
    if (!point.visible && takes_part(row)) evaluation.valid = false;
    evaluation.residual[2 * row] = point.visible ? data_.u_px[row] - point.u : 0;
    evaluation.residual[2 * row + 1] = point.visible ? data_.v_px[row] - point.v : 0;
  }
  whiten_diagonal(*this, groups, evaluation);
  const std::optional<FewErrors> scatter = scatter_of(model);
  if (!has_shared_causes(predictor)) {
    if (scatter) whiten_all_scattered(*scatter, groups, evaluation);
    return evaluation;
  }
  // Slopes hardly change on the way of a fit: it keeps those of its start and renews them.
  if (warm && warm->valid && warm->reusable) {
    evaluation.reusable = warm->reusable;
  } else {
    evaluation.reusable = std::make_shared<const Slopes>(slopes_of(predictor, groups));
  }
  whiten_frames(predictor, groups, *static_cast<const Slopes*>(evaluation.reusable.get()), scatter,
                evaluation);
  return evaluation;
}

void PointsProblem::whiten_all_scattered(const FewErrors& scatter, const Groups& groups,
                                         Evaluation& evaluation) const {
  std::vector<size_t> scalars;
  for (size_t i = 0; i < facts_.scalars(); ++i) {
    if (groups[facts_.group_of(i)]) scalars.push_back(i);
  }
  whiten_scattered(scatter, scalars, Eigen::MatrixXd(scalars.size(), 0), facts_, evaluation);
}

PointsProblem::Slopes PointsProblem::slopes_of(const PointsPredictor& predictor,
                                               const Groups& groups) const {
  const size_t joints = data_.rig.type() == Rig::Type::chain ? data_.rig.joint_names().size() : 0;
  Slopes slopes{.width = 2 * (1 + joints)};
  slopes.by_row.assign(data_.p_W.size() * slopes.width, 0);
  slopes.instant_s.assign(data_.p_W.size(), 0);
  for (size_t row = 0; row < data_.p_W.size(); ++row) {
    if (!groups[facts_.group_of_row[row]]) continue;
    const effects::ImagePoint here = predictor.image(row);
    slopes.instant_s[row] = predictor.instant(row, here.v);
    for (size_t cause = 0; cause < 1 + joints; ++cause) {
      std::vector<double> errors(joints, 0);
      const double by = cause == 0 ? 1e-5 : 1e-6;
      if (cause > 0) errors[cause - 1] = by;
      const effects::ImagePoint there =
          predictor.image(row, cause == 0 ? by : 0, errors.empty() ? nullptr : errors.data());
      if (!there.visible || !here.visible) continue;
      slopes.by_row[row * slopes.width + 2 * cause] = (there.u - here.u) / by;
      slopes.by_row[row * slopes.width + 2 * cause + 1] = (there.v - here.v) / by;
    }
  }
  return slopes;
}

// Jitter moves all points of a frame together; rounding of the encoder moves those seen between
// the same two samples of its log together.
Eigen::MatrixXd PointsProblem::shared_causes(const PointsPredictor& predictor, const Slopes& slopes,
                                             const std::vector<size_t>& scalars) const {
  const double jitter = predictor.timing().jitter_sigma_s;
  const double step = predictor.motion().quantisation_step_rad / std::sqrt(12.0);
  const size_t joints = step > 0 ? slopes.width / 2 - 1 : 0;
  const std::vector<double>& log = data_.rig.log_times();
  double early = 1e300, late = -1e300;
  for (const size_t scalar : scalars) {
    early = std::min(early, slopes.instant_s[scalar / 2]);
    late = std::max(late, slopes.instant_s[scalar / 2]);
  }
  size_t first = 0, nodes = 0;
  if (joints > 0 && !scalars.empty()) {
    first = std::upper_bound(log.begin(), log.end(), early) - log.begin();
    first = first > 0 ? first - 1 : 0;
    const size_t last = std::min<size_t>(
        std::upper_bound(log.begin(), log.end(), late) - log.begin(), log.size() - 1);
    nodes = last - first + 1;
  }
  Eigen::MatrixXd causes =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(scalars.size()),
                            static_cast<Eigen::Index>((jitter > 0 ? 1 : 0) + nodes * joints));
  for (size_t k = 0; k < scalars.size(); ++k) {
    const size_t row = scalars[k] / 2;
    const double* slope = &slopes.by_row[row * slopes.width + scalars[k] % 2];
    Eigen::Index column = 0;
    if (jitter > 0) causes(static_cast<Eigen::Index>(k), column++) = jitter * slope[0];
    for (size_t j = 0; j < joints; ++j) {
      const double t = slopes.instant_s[row];
      for (size_t node = first; node < first + nodes; ++node, ++column) {
        const double width = t < log[node]
                                 ? (node > 0 ? log[node] - log[node - 1] : 1)
                                 : (node + 1 < log.size() ? log[node + 1] - log[node] : 1);
        causes(static_cast<Eigen::Index>(k), column) =
            step * slope[2 * (1 + j)] * std::max(0.0, 1 - std::abs(t - log[node]) / width);
      }
    }
  }
  return causes;
}

void PointsProblem::whiten_frames(const PointsPredictor& predictor, const Groups& groups,
                                  const Slopes& slopes, const std::optional<FewErrors>& scatter,
                                  Evaluation& evaluation) const {
  for (const std::vector<int>& rows : data_.rows_of_frame) {
    if (!groups[facts_.group_of_row[rows.front()]]) continue;
    std::vector<size_t> scalars;
    for (const int row : rows) {
      for (size_t c = 0; c < 2; ++c) {
        if (evaluation.used[2 * row + c] || scatter) scalars.push_back(2 * row + c);
      }
    }
    if (scalars.empty()) continue;
    const Eigen::MatrixXd causes = shared_causes(predictor, slopes, scalars);
    if (scatter) {
      whiten_scattered(*scatter, scalars, causes, facts_, evaluation);
    } else {
      whiten_low_rank(scalars, causes, facts_.group_of_row[rows.front()], evaluation);
    }
  }
}

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
