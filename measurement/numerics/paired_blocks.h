// Normal equations of unknowns of two sorts, such as the poses of views and the places of points,
// where each observation joins one of each sort and nothing joins two of one sort. A path through
// many views is one of them, with many unknowns. The sort with
// more unknowns is eliminated block by block (Schur's complement), so that thousands of points in
// tens of views, or hundreds of views of tens of points, cost little.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace seam::measurement {

class PairedBlocks {
 public:
  using Slopes = Eigen::Matrix<double, 2, Eigen::Dynamic>;

  // Views have unknowns of their own number each (0 where one takes no part), points three; no
  // points: views alone.
  PairedBlocks(const std::vector<Eigen::Index>& view_sizes, size_t points);

  // An observation of two numbers with these derivatives: by the view's unknowns from this one on
  // (it hangs on no other of them), and by the point's.
  void add(size_t view, Eigen::Index from, const Slopes& by_view, size_t point,
           const Eigen::Matrix<double, 2, 3>& by_point);
  // What an unknown is known by beforehand.
  void add_prior(size_t view, Eigen::Index unknown, double precision);
  void add_prior(size_t point, const Eigen::Matrix3d& precision);

  Eigen::Index view_unknowns() const { return view_at_.back(); }
  Eigen::Index point_unknowns() const { return 3 * static_cast<Eigen::Index>(points_.size()); }
  Eigen::Index view_at(size_t view) const { return view_at_[view]; }
  const Eigen::MatrixXd& of_view(size_t view) const { return views_[view]; }
  const Eigen::Matrix3d& of_point(size_t point) const { return points_[point]; }

  // False where the unknowns are not determined. `damping` is in shares of each diagonal entry.
  bool factor(double damping);
  // Solutions for these right sides, one a column; after factor.
  void solve(Eigen::MatrixXd& views, Eigen::MatrixXd& points) const;
  // Of the whole matrix; after factor.
  double log_det() const { return log_det_; }
  // Of each point with the views' unknowns estimated as well; after factor.
  std::vector<Eigen::Matrix3d> point_covariances() const;
  // The same of each view with the points' unknowns estimated.
  std::vector<Eigen::MatrixXd> view_covariances() const;

 private:
  // A block of the one sort as seen from a block of the other.
  struct Cell {
    size_t view, point;
    size_t at;           // Of its product of derivatives in joint_: unknowns x 3, by columns.
    Eigen::Index first;  // Among all views' unknowns, of those that it hangs on,
    Eigen::Index count;  // and how many these are.
  };
  Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3>> joint(const Cell& cell) const;
  Eigen::MatrixXd all_joint(size_t view) const;
  Eigen::MatrixXd damped_view(size_t view, double damping) const;
  Eigen::Matrix3d damped_point(size_t point, double damping) const;
  Eigen::Index size_of(size_t view) const { return view_at_[view + 1] - view_at_[view]; }
  class Products;
  void eliminate_points(double damping);
  void eliminate_views(double damping);

  std::vector<Eigen::Index> view_at_;  // First unknown of each view, and the end.
  std::vector<Eigen::MatrixXd> views_;
  std::vector<Eigen::Matrix3d> points_;
  std::vector<Cell> cells_;
  std::vector<double> joint_;
  std::vector<std::vector<size_t>> cells_of_view_, cells_of_point_;
  // After factor: inverses of the eliminated blocks, the reduced matrix and its inverse triangle.
  bool points_eliminated_ = true;
  std::vector<Eigen::MatrixXd> view_inverse_;
  std::vector<Eigen::Matrix3d> point_inverse_;
  double log_det_ = 0;
  Eigen::MatrixXd reduced_;  // Its Cholesky factor, below the diagonal.
};

}  // namespace seam::measurement
