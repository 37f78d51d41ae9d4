// What an adjustment of a target's draws tells the engine: residuals, determinants, derivatives.
#include <Eigen/Dense>
#include <cmath>

#include "measurement/kinds/points/points_predictor.h"
#include "measurement/kinds/points/target_adjustment.h"
#include "measurement/numerics/parallel_for.h"

namespace seam::measurement {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// Lower triangle L of L L' = m.
Matrix3d triangle(const Matrix3d& m) {
  return m.llt().matrixL();
}

double log_det(const MatrixXd& m) {
  return 2 * m.llt().matrixLLT().diagonal().array().log().sum();
}

}  // namespace

void TargetAdjustment::tell_residuals(Evaluation& evaluation) const {
  parallel_for(state_.X_CW.size(), [&](size_t frame) {
    if (!given_.frames[frame]) return;
    for (const int r : given_.data.rows_of_frame[frame]) {  // Outliers too: they may come back.
      const auto row = static_cast<size_t>(r);
      Vector2d uv;
      const bool seen = see(compiled_, state_, row, uv);
      evaluation.residual[2 * row] = seen ? given_.data.u_px[row] - uv[0] : 0;
      evaluation.residual[2 * row + 1] = seen ? given_.data.v_px[row] - uv[1] : 0;
    }
  });
}

// What is left of the k-th used row where the adjustment stands: its residual less the causes.
Vector2d TargetAdjustment::left_over(size_t row, const Cell& cell,
                                     const Evaluation& evaluation) const {
  const auto frame = static_cast<size_t>(given_.data.frame_of_row[row]);
  Vector2d z(evaluation.residual[2 * row] / given_.sigma[2 * row],
             evaluation.residual[2 * row + 1] / given_.sigma[2 * row + 1]);
  const Index causes = given_.causes.empty() ? 0 : given_.causes[frame].cols();
  return z + cell.by_view.rightCols(causes) * state_.extra[frame].tail(causes);
}

std::vector<size_t> TargetAdjustment::used_rows() const {
  std::vector<size_t> used;
  for (size_t frame = 0; frame < state_.X_CW.size(); ++frame) {
    if (!given_.frames[frame]) continue;
    for (const int row : given_.data.rows_of_frame[frame]) {
      if (given_.rows[static_cast<size_t>(row)]) used.push_back(static_cast<size_t>(row));
    }
  }
  return used;
}

PairedBlocks TargetAdjustment::blocks_of_draws(const std::vector<size_t>& used) const {
  std::vector<Index> sizes;
  for (size_t frame = 0; frame < state_.extra.size(); ++frame)
    sizes.push_back(given_.frames[frame] ? state_.extra[frame].size() : 0);
  PairedBlocks draws(sizes, has_points() ? state_.displaced_m.size() : 0);
  for (size_t k = 0; k < used.size(); ++k) {
    const auto frame = static_cast<size_t>(given_.data.frame_of_row[used[k]]);
    draws.add(frame, 0, cells_[k].by_view.rightCols(sizes[frame]),
              static_cast<size_t>(given_.data.point_of_row[used[k]]), cells_[k].by_point);
  }
  for (size_t frame = 0; frame < sizes.size(); ++frame) {
    for (Index i = 0; i < sizes[frame]; ++i) draws.add_prior(frame, i, 1);
  }
  for (size_t point = 0; point < state_.displaced_m.size() && has_points(); ++point)
    draws.add_prior(point, precision(point));
  return draws;
}

// How much less log det S is over what a view's pose cannot follow: what it can, it takes, and that
// says nothing of the view's draws.
double TargetAdjustment::log_det_of_pose(size_t frame) const {
  const Index poses = pose_unknowns(), extras = state_.extra[frame].size();
  if (poses == 0 || extras == 0) return 0;
  const MatrixXd& view = blocks_->of_view(frame);
  const double less = log_det(view) - log_det(view.topLeftCorner(poses, poses)) -
                      log_det(view.bottomRightCorner(extras, extras));
  return std::isfinite(less) ? less : 0;
}

// By how much larger covariances of a view's draws are because its pose follows them.
MatrixXd TargetAdjustment::left_by_pose(size_t frame) const {
  const Index poses = pose_unknowns(), extras = state_.extra[frame].size();
  if (poses == 0 || extras == 0) return MatrixXd::Zero(extras, extras);
  const MatrixXd& view = blocks_->of_view(frame);
  const MatrixXd more = view.inverse().bottomRightCorner(extras, extras) -
                        view.bottomRightCorner(extras, extras).inverse();
  return more.allFinite() ? more : MatrixXd::Zero(extras, extras);
}

void TargetAdjustment::whiten(Evaluation& evaluation) const {
  const std::vector<size_t> used = used_rows();
  for (size_t k = 0; k < used.size(); ++k) {
    const Cell& cell = cells_[k];
    const Index extras =
        state_.extra[static_cast<size_t>(given_.data.frame_of_row[used[k]])].size();
    for (int c = 0; c < 2; ++c) {
      const size_t scalar = 2 * used[k] + static_cast<size_t>(c);
      evaluation.whitened[scalar] = left_over(used[k], cell, evaluation)[c];
      evaluation.sigma[scalar] *=
          std::sqrt(1 + cell.by_view.row(c).tail(extras - causes_at()).squaredNorm());
    }
  }
  PairedBlocks draws = blocks_of_draws(used);
  for (size_t frame = 0; frame < state_.extra.size(); ++frame) {
    if (!given_.frames[frame]) continue;
    evaluation.shared_log_det += log_det_of_pose(frame);
    for (Index i = 0; i < state_.extra[frame].size(); ++i) {
      evaluation.whitened.push_back(state_.extra[frame][i]);
      evaluation.absorbed += 1 - 1 / draws.of_view(frame)(i, i);
    }
  }
  for (size_t point = 0; point < state_.displaced_m.size() && has_points(); ++point) {
    const Matrix3d before = precision(point);
    evaluation.shared_log_det -= std::log(before.determinant());
    evaluation.absorbed += 3 - (before * draws.of_point(point).inverse()).trace();
    const Vec3& d = state_.displaced_m[point];
    const Vector3d away = triangle(before).transpose() * (Vector3d(d.x, d.y, d.z) - mean(point));
    evaluation.whitened.insert(evaluation.whitened.end(), {away[0], away[1], away[2]});
  }
  if (draws.factor(0)) evaluation.shared_log_det += draws.log_det();
}

// By scalar of the used rows: residuals over their sigmas by an unknown, where it stands.
Eigen::VectorXd TargetAdjustment::slopes_by(const Model& moved, double step,
                                            const std::vector<size_t>& used) const {
  const Compiled there(given_.data, moved);
  Eigen::VectorXd slopes = Eigen::VectorXd::Zero(2 * static_cast<Index>(used.size()));
  for (size_t k = 0; k < used.size(); ++k) {
    Vector2d uv;
    if (!see(there, state_, used[k], uv)) continue;
    for (int c = 0; c < 2; ++c)
      slopes[2 * static_cast<Index>(k) + c] =
          -(uv[c] - cells_[k].uv[c]) / (step * given_.sigma[2 * used[k] + static_cast<size_t>(c)]);
  }
  return slopes;
}

// Lets all nuisances follow an unknown: notes how they do, and returns what is left of its slopes.
std::vector<double> TargetAdjustment::column_of(const Eigen::VectorXd& slopes,
                                                const std::vector<size_t>& used, size_t unknown) {
  MatrixXd views = MatrixXd::Zero(blocks_->view_unknowns(), 1);
  MatrixXd points = MatrixXd::Zero(blocks_->point_unknowns(), 1);
  const auto views_of = [&](size_t k) {
    const auto frame = static_cast<size_t>(given_.data.frame_of_row[used[k]]);
    return views.col(0).segment(blocks_->view_at(view_of(frame)) + cells_[k].from,
                                cells_[k].by_view.cols());
  };
  const auto points_of = [&](size_t k) {
    return points.col(0).segment<3>(3 * static_cast<Index>(given_.data.point_of_row[used[k]]));
  };
  for (size_t k = 0; k < used.size(); ++k) {
    const Vector2d by = slopes.segment<2>(2 * static_cast<Index>(k));
    views_of(k).noalias() += cells_[k].by_view.transpose() * by;
    if (has_points()) points_of(k).noalias() += cells_[k].by_point.transpose() * by;
  }
  blocks_->solve(views, points);
  std::vector<double> column(2 * given_.data.p_W.size(), 0);
  for (size_t k = 0; k < used.size(); ++k) {
    Vector2d left = slopes.segment<2>(2 * static_cast<Index>(k));
    left.noalias() -= cells_[k].by_view * views_of(k);
    if (has_points()) left.noalias() -= cells_[k].by_point * points_of(k);
    column[2 * used[k]] = left[0], column[2 * used[k] + 1] = left[1];
  }
  // The draws follow, too: their part of the columns, in the order of `whiten`.
  for (size_t frame = 0; frame < state_.extra.size(); ++frame) {
    if (unknowns(frame) == 0 || state_.extra[frame].size() == 0) continue;
    const Index at = blocks_->view_at(frame) + pose_unknowns();
    for (Index i = at; i < blocks_->view_at(frame + 1); ++i) column.push_back(-views(i, 0));
  }
  for (size_t point = 0; point < state_.displaced_m.size() && has_points(); ++point) {
    const Vector3d part = -(triangle(precision(point)).transpose() *
                            points.block<3, 1>(3 * static_cast<Index>(point), 0));
    column.insert(column.end(), {part[0], part[1], part[2]});
  }
  following_views_.col(static_cast<Index>(unknown)) = views;
  following_points_.col(static_cast<Index>(unknown)) = points;
  return column;
}

std::vector<std::vector<double>> TargetAdjustment::columns(const std::vector<Model>& moved,
                                                           const std::vector<double>& steps) {
  MatrixXd views, points;
  if (!build(views, points) || !blocks_->factor(0)) return {};
  const std::vector<size_t> used = used_rows();
  const auto count = static_cast<Index>(moved.size());
  following_views_.resize(views.rows(), count + 1);
  following_points_.resize(points.rows(), count + 1);
  std::vector<std::vector<double>> columns(moved.size());
  parallel_for(moved.size() + 1, [&](size_t p) {
    if (p < moved.size()) {
      columns[p] = column_of(slopes_by(moved[p], steps[p], used), used, p);
      return;
    }
    // Behind what follows the unknowns: the nuisances' own way.
    blocks_->solve(views, points);
    following_views_.col(count) = views, following_points_.col(count) = points;
  });
  return columns;
}

// Residuals over their sigmas, and the draws over their spreads behind them, as `columns` has them.
std::vector<double> TargetAdjustment::left_with_draws(const std::vector<size_t>& used) const {
  std::vector<double> left(2 * given_.data.p_W.size(), 0);
  for (size_t k = 0; k < used.size(); ++k) {
    for (int c = 0; c < 2; ++c) left[2 * used[k] + static_cast<size_t>(c)] = cells_[k].z[c];
  }
  for (size_t frame = 0; frame < state_.extra.size(); ++frame) {
    if (given_.frames[frame])
      left.insert(left.end(), state_.extra[frame].begin(), state_.extra[frame].end());
  }
  for (size_t point = 0; point < state_.displaced_m.size() && has_points(); ++point) {
    const Vec3& d = state_.displaced_m[point];
    const Vector3d away =
        triangle(precision(point)).transpose() * (Vector3d(d.x, d.y, d.z) - mean(point));
    left.insert(left.end(), {away[0], away[1], away[2]});
  }
  return left;
}

std::optional<Parabola> TargetAdjustment::look(const std::vector<Model>& moved,
                                               const std::vector<double>& steps) {
  const auto all = columns(moved, steps);
  if (all.size() != moved.size()) return std::nullopt;
  const std::vector<double> left = left_with_draws(used_rows());
  const auto count = static_cast<Index>(all.size()), rows = static_cast<Index>(left.size());
  MatrixXd jacobian(rows, count);
  for (Index k = 0; k < count; ++k)
    jacobian.col(k) = Eigen::Map<const Eigen::VectorXd>(all[static_cast<size_t>(k)].data(), rows);
  return parabola_of(jacobian, Eigen::Map<const Eigen::VectorXd>(left.data(), rows));
}

std::vector<double> TargetAdjustment::values_after(const Eigen::VectorXd& by) const {
  const auto step = [&](const MatrixXd& following) -> MatrixXd {
    return following.rightCols(1) - following.leftCols(by.size()) * by;
  };
  return values_of(moved(step(following_views_), step(following_points_), 1));
}

TargetAdjustment::DrawsSums TargetAdjustment::squares() const {
  DrawsSums sums;
  for (size_t point = 0; point < state_.displaced_m.size() && has_points(); ++point) {
    const Vec3& d = state_.displaced_m[point];
    const Vector3d away = Vector3d(d.x, d.y, d.z) - mean(point);
    sums.points.square += away.dot(precision(point) * away);
  }
  for (size_t frame = 0; frame < state_.extra.size(); ++frame) {
    if (!given_.frames[frame]) continue;
    const Eigen::VectorXd& extra = state_.extra[frame];
    if (has_flex()) sums.bendings.square += extra[0] * extra[0];
    sums.focuses.square += extra.segment(focus_at(0), motion_at() - focus_at(0)).squaredNorm();
    sums.motions.square += extra.segment(motion_at(), sway_at(1) - motion_at()).squaredNorm();
    for (Index at = sway_at(1); at < causes_at(); at += 6) {
      sums.shifts.square += extra.segment<3>(at).squaredNorm();
      sums.turns.square += extra.segment<3>(at + 3).squaredNorm();
    }
  }
  return sums;
}

TargetAdjustment::DrawsSums TargetAdjustment::sums() const {
  DrawsSums sums = squares();
  PairedBlocks draws = blocks_of_draws(used_rows());
  if (!draws.factor(0)) return sums;
  const std::vector<Matrix3d> of_points = draws.point_covariances();
  for (size_t point = 0; point < of_points.size(); ++point) {
    const Matrix3d told = Matrix3d::Identity() - precision(point) * of_points[point];
    sums.points.freedom += told.trace();
    sums.points.information += 2 * (told * told).trace();
  }
  const std::vector<MatrixXd> of_views = draws.view_covariances();
  for (size_t frame = 0; frame < of_views.size(); ++frame) {
    if (!given_.frames[frame]) continue;
    const MatrixXd covariance = of_views[frame] + left_by_pose(frame);
    const auto add = [&](Index at, Index size, DrawsSum& sum) {
      const MatrixXd told = MatrixXd::Identity(size, size) - covariance.block(at, at, size, size);
      sum.freedom += told.trace();
      sum.information += 2 * (told * told).trace();
    };
    if (has_flex()) add(0, 1, sums.bendings);
    add(focus_at(0), motion_at() - focus_at(0), sums.focuses);
    add(motion_at(), sway_at(1) - motion_at(), sums.motions);
    for (Index at = sway_at(1); at < causes_at(); at += 6) {
      add(at, 3, sums.shifts);
      add(at + 3, 3, sums.turns);
    }
  }
  return sums;
}

}  // namespace seam::measurement
