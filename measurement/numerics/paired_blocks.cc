#include "measurement/numerics/paired_blocks.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "measurement/numerics/parallel_for.h"

namespace seam::measurement {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;

namespace {

// A view of so many unknowns meets each point in many observations, whose products are added up
// before they meet the others.
constexpr Index kLargeView = 64;

}  // namespace

PairedBlocks::PairedBlocks(const std::vector<Index>& view_sizes, size_t points)
    : view_at_{0},
      points_(points, Matrix3d::Zero()),
      cells_of_view_(view_sizes.size()),
      cells_of_point_(points) {
  for (const Index size : view_sizes) {
    views_.emplace_back(MatrixXd::Zero(size, size));
    view_at_.push_back(view_at_.back() + size);
  }
}

void PairedBlocks::add(size_t view, Index from, const Slopes& by_view, size_t point,
                       const Eigen::Matrix<double, 2, 3>& by_point) {
  const Index count = by_view.cols();
  views_[view].block(from, from, count, count).noalias() += by_view.transpose() * by_view;
  if (points_.empty()) return;
  points_[point].noalias() += by_point.transpose() * by_point;
  const Cell cell{view, point, joint_.size(), view_at_[view] + from, count};
  joint_.resize(joint_.size() + 3 * static_cast<size_t>(count));
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 3>>(joint_.data() + cell.at, count, 3) =
      by_view.transpose() * by_point;
  cells_of_view_[view].push_back(cells_.size());
  cells_of_point_[point].push_back(cells_.size());
  cells_.push_back(cell);
}

void PairedBlocks::add_prior(size_t view, Index unknown, double precision) {
  views_[view](unknown, unknown) += precision;
}

void PairedBlocks::add_prior(size_t point, const Matrix3d& precision) {
  points_[point] += precision;
}

Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3>> PairedBlocks::joint(
    const Cell& cell) const {
  return {joint_.data() + cell.at, cell.count, 3};
}

// Of a view, by its unknowns and all points'.
MatrixXd PairedBlocks::all_joint(size_t view) const {
  MatrixXd all = MatrixXd::Zero(size_of(view), point_unknowns());
  for (const size_t c : cells_of_view_[view])
    all.block(cells_[c].first - view_at_[view], 3 * static_cast<Index>(cells_[c].point),
              cells_[c].count, 3) += joint(cells_[c]);
  return all;
}

MatrixXd PairedBlocks::damped_view(size_t view, double damping) const {
  MatrixXd block = views_[view];
  block.diagonal() *= 1 + damping;
  return block;
}

Matrix3d PairedBlocks::damped_point(size_t point, double damping) const {
  Matrix3d block = points_[point];
  block.diagonal() *= 1 + damping;
  return block;
}

// Takes the products of many eliminated blocks with themselves from the reduced matrix: below its
// diagonal, as one product of large matrices.
class PairedBlocks::Products {
 public:
  Products(MatrixXd& reduced, Index most_columns)
      : reduced_(reduced), columns_(MatrixXd::Zero(reduced.rows(), most_columns)) {}
  ~Products() { take(); }

  // The next `count` columns, all zero.
  auto next(Index count) {
    if (used_ + count > columns_.cols()) take();
    used_ += count;
    return columns_.middleCols(used_ - count, count);
  }

 private:
  void take() {
    reduced_.selfadjointView<Eigen::Lower>().rankUpdate(columns_.leftCols(used_), -1);
    columns_.leftCols(used_).setZero();
    used_ = 0;
  }

  MatrixXd& reduced_;
  MatrixXd columns_;
  Index used_ = 0;
};

void PairedBlocks::eliminate_points(double damping) {
  reduced_ = MatrixXd::Zero(view_unknowns(), view_unknowns());
  for (size_t v = 0; v < views_.size(); ++v)
    reduced_.block(view_at_[v], view_at_[v], size_of(v), size_of(v)) = damped_view(v, damping);
  point_inverse_.resize(points_.size());
  // Two shares, for two cores.
  MatrixXd second = MatrixXd::Zero(view_unknowns(), view_unknowns());
  double log_dets[2] = {0, 0};
  parallel_for(2, [&](size_t share) {
    Products products(share == 0 ? reduced_ : second, 3 * 128);
    const size_t middle = points_.size() / 2;
    for (size_t p = share == 0 ? 0 : middle; p < (share == 0 ? middle : points_.size()); ++p) {
      const Eigen::LLT<Matrix3d> root(damped_point(p, damping));
      const Matrix3d half = root.matrixU().solve(Matrix3d::Identity());  // half half' = inverse
      log_dets[share] += 2 * Matrix3d(root.matrixL()).diagonal().array().log().sum();
      point_inverse_[p] = half * half.transpose();
      auto columns = products.next(3);
      for (const size_t c : cells_of_point_[p])
        columns.middleRows(cells_[c].first, cells_[c].count).noalias() +=
            joint(cells_[c]).lazyProduct(half);
    }
  });
  reduced_ += second;
  log_det_ += log_dets[0] + log_dets[1];
}

void PairedBlocks::eliminate_views(double damping) {
  reduced_ = MatrixXd::Zero(point_unknowns(), point_unknowns());
  for (size_t p = 0; p < points_.size(); ++p)
    reduced_.block<3, 3>(3 * static_cast<Index>(p), 3 * static_cast<Index>(p)) =
        damped_point(p, damping);
  view_inverse_.clear();
  Index widest = 1;
  for (size_t v = 0; v < views_.size(); ++v) widest = std::max(widest, size_of(v));
  Products products(reduced_, widest < kLargeView ? 64 * widest : widest);
  for (size_t v = 0; v < views_.size(); ++v) {
    const Index size = size_of(v);
    view_inverse_.emplace_back(size, size);
    if (size == 0) continue;
    const Eigen::LLT<MatrixXd> root(damped_view(v, damping));
    const MatrixXd half = root.matrixU().solve(MatrixXd::Identity(size, size));
    log_det_ += 2 * MatrixXd(root.matrixL()).diagonal().array().log().sum();
    view_inverse_.back() = half * half.transpose();
    auto columns = products.next(size);
    if (size >= kLargeView) {
      columns.noalias() += all_joint(v).transpose() * half;
      continue;
    }
    for (const size_t c : cells_of_view_[v])
      columns.middleRows<3>(3 * static_cast<Index>(cells_[c].point)) +=
          joint(cells_[c]).transpose() *
          half.middleRows(cells_[c].first - view_at_[v], cells_[c].count);
  }
}

bool PairedBlocks::factor(double damping) {
  points_eliminated_ = point_unknowns() >= view_unknowns();
  log_det_ = 0;
  if (points_eliminated_) {
    eliminate_points(damping);
  } else {
    eliminate_views(damping);
  }
  if (!reduced_.allFinite()) return false;
  if (!std::isfinite(log_det_)) return false;
  if (reduced_.rows() == 0) return true;
  const Eigen::LLT<Eigen::Ref<MatrixXd>> solver(reduced_);
  if (solver.info() != Eigen::Success) return false;
  log_det_ += 2 * reduced_.diagonal().array().log().sum();
  return true;
}

void PairedBlocks::solve(MatrixXd& views, MatrixXd& points) const {
  const auto back = [&](MatrixXd& right) {
    const auto triangle = reduced_.triangularView<Eigen::Lower>();
    triangle.solveInPlace(right);
    triangle.transpose().solveInPlace(right);
  };
  if (points_eliminated_) {
    MatrixXd alone(points.rows(), points.cols());  // As if no view followed.
    for (size_t p = 0; p < points_.size(); ++p) {
      const Index at = 3 * static_cast<Index>(p);
      alone.middleRows<3>(at).noalias() = point_inverse_[p] * points.middleRows<3>(at);
    }
    for (const Cell& cell : cells_) {
      views.middleRows(cell.first, cell.count).noalias() -=
          joint(cell).lazyProduct(alone.middleRows<3>(3 * static_cast<Index>(cell.point)));
    }
    if (views.rows() > 0) back(views);
    for (const Cell& cell : cells_) {
      points.middleRows<3>(3 * static_cast<Index>(cell.point)).noalias() -=
          joint(cell).transpose().lazyProduct(views.middleRows(cell.first, cell.count));
    }
    for (size_t p = 0; p < points_.size(); ++p) {
      auto rows = points.middleRows<3>(3 * static_cast<Index>(p));
      rows = (point_inverse_[p] * rows).eval();
    }
    return;
  }
  MatrixXd alone(views.rows(), views.cols());  // As if no point followed.
  for (size_t v = 0; v < views_.size(); ++v)
    alone.middleRows(view_at_[v], size_of(v)) =
        view_inverse_[v] * views.middleRows(view_at_[v], size_of(v));
  for (const Cell& cell : cells_) {
    points.middleRows<3>(3 * static_cast<Index>(cell.point)) -=
        joint(cell).transpose() * alone.middleRows(cell.first, cell.count);
  }
  back(points);
  for (const Cell& cell : cells_) {
    views.middleRows(cell.first, cell.count) -=
        joint(cell) * points.middleRows<3>(3 * static_cast<Index>(cell.point));
  }
  for (size_t v = 0; v < views_.size(); ++v) {
    auto rows = views.middleRows(view_at_[v], size_of(v));
    rows = (view_inverse_[v] * rows).eval();
  }
}

std::vector<Matrix3d> PairedBlocks::point_covariances() const {
  std::vector<Matrix3d> all;
  const Index n = reduced_.rows();
  MatrixXd inverse = MatrixXd::Identity(n, n);
  reduced_.triangularView<Eigen::Lower>().solveInPlace(inverse);
  MatrixXd rows;
  for (size_t p = 0; p < points_.size(); ++p) {
    if (!points_eliminated_) {
      const auto part = inverse.middleCols<3>(3 * static_cast<Index>(p));
      all.emplace_back(part.transpose() * part);
      continue;
    }
    rows = MatrixXd::Zero(n, 3);
    for (const size_t c : cells_of_point_[p]) {
      const Cell& cell = cells_[c];
      rows += inverse.middleCols(cell.first, cell.count) * (joint(cell) * point_inverse_[p]);
    }
    all.emplace_back(point_inverse_[p] + rows.transpose() * rows);
  }
  return all;
}

std::vector<MatrixXd> PairedBlocks::view_covariances() const {
  std::vector<MatrixXd> all;
  const Index n = reduced_.rows();
  MatrixXd inverse = MatrixXd::Identity(n, n);
  reduced_.triangularView<Eigen::Lower>().solveInPlace(inverse);
  for (size_t v = 0; v < views_.size(); ++v) {
    if (points_eliminated_) {
      const auto part = inverse.middleCols(view_at_[v], size_of(v));
      all.emplace_back(part.transpose() * part);
      continue;
    }
    MatrixXd rows = MatrixXd::Zero(n, size_of(v));
    for (const size_t c : cells_of_view_[v])
      rows += inverse.middleCols<3>(3 * static_cast<Index>(cells_[c].point)) *
              (joint(cells_[c]).transpose() *
               view_inverse_[v].middleRows(cells_[c].first - view_at_[v], cells_[c].count));
    all.emplace_back(view_inverse_[v] + rows.transpose() * rows);
  }
  return all;
}

}  // namespace seam::measurement
