#include "measurement/kinds/points/motion/path_adjustment.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <limits>

namespace seam::measurement {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;

namespace {

constexpr Index kBand = 4 * kControlUnknowns;  // Controls that act together are neighbours.

// Normal equations whose entries lie near the diagonal; their factor costs as much as it has
// entries.
class Band {
 public:
  explicit Band(size_t controls)
      : entries_(MatrixXd::Zero(kBand, kControlUnknowns * static_cast<Index>(controls))) {}

  template <class Slopes>
  void add(Index first, const Slopes& slopes) {
    const Index count = slopes.cols();
    for (Index j = 0; j < count; ++j)
      entries_.col(first + j).head(count - j) +=
          slopes(0, j) * slopes.row(0).tail(count - j).transpose() +
          slopes(1, j) * slopes.row(1).tail(count - j).transpose();
  }

  bool factor(double damping) {
    double largest[kControlUnknowns] = {};
    for (Index j = 0; j < entries_.cols(); ++j)
      largest[j % kControlUnknowns] = std::max(largest[j % kControlUnknowns], entries_(0, j));
    std::vector<Eigen::Triplet<double>> all;
    for (Index j = 0; j < entries_.cols(); ++j) {
      for (Index i = 0; i < kBand && i + j < entries_.cols(); ++i) {
        double value = entries_(i, j);
        if (i == 0) value += damping * value + hold_of_control(largest[j % kControlUnknowns]);
        if (value != 0) all.emplace_back(static_cast<int>(i + j), static_cast<int>(j), value);
      }
    }
    Eigen::SparseMatrix<double> lower(entries_.cols(), entries_.cols());
    lower.setFromTriplets(all.begin(), all.end());
    solver_.compute(lower);
    return solver_.info() == Eigen::Success;
  }

  MatrixXd solve(const MatrixXd& right) const { return solver_.solve(right); }

 private:
  MatrixXd entries_;  // Row i: i below the diagonal.
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>>
      solver_;
};

}  // namespace

bool PathAdjustment::looks(const RowCamera& camera, const std::vector<Control>& controls,
                           std::vector<PathLook>& all) const {
  all.resize(seen_.size());
  for (size_t i = 0; i < seen_.size(); ++i) {
    if (!look_on_path(layout_, camera, controls, seen_[i], all[i])) return false;
  }
  return true;
}

double PathAdjustment::cost_of(const std::vector<PathLook>& all) {
  double sum = 0;
  for (const PathLook& look : all) sum += look.z.squaredNorm();
  return 0.5 * sum;
}

double PathAdjustment::cost(const RowCamera& camera, const std::vector<Control>& controls) const {
  double sum = 0;
  for (const PathSighting& point : seen_) {
    Vector2d uv;
    if (!image(camera, controls, point, uv)) return std::numeric_limits<double>::infinity();
    const double u = (point.u_px - uv[0]) / point.sigma_u, v = (point.v_px - uv[1]) / point.sigma_v;
    sum += u * u + v * v;
  }
  return 0.5 * sum;
}

bool PathAdjustment::fit(const RowCamera& camera, std::vector<Control>& controls) const {
  constexpr int kSteps = 30, kAttempts = 10;
  // Of log-likelihood: less is not worth a step, and a step that promised less was the last.
  constexpr double kEnough = 1e-7, kSettled = 1e-4;
  double here = std::numeric_limits<double>::infinity(), damping = 0;
  std::vector<PathLook> all;
  for (int step = 0; step < kSteps; ++step) {
    if (!looks(camera, controls, all)) return false;
    if (step == 0) here = cost_of(all);
    Band band(controls.size());
    MatrixXd right = MatrixXd::Zero(kControlUnknowns * static_cast<Index>(controls.size()), 1);
    for (const PathLook& look : all) {
      const Index first = kControlUnknowns * static_cast<Index>(look.weights.first),
                  count = kControlUnknowns * look.weights.count;
      band.add(first, look.by_controls.leftCols(count));
      right.middleRows(first, count) -= look.by_controls.leftCols(count).transpose() * look.z;
    }
    bool taken = false;
    for (int attempt = 0; attempt < kAttempts && !taken; ++attempt) {
      if (band.factor(damping)) {
        const MatrixXd by = band.solve(right);
        const double promised = 0.5 * by.col(0).dot(right.col(0));
        if (promised < kEnough * (1 + 1e-6 * here)) return true;
        std::vector<Control> there;
        for (size_t k = 0; k < controls.size(); ++k)
          there.push_back(moved_control(
              controls[k],
              by.block<kControlUnknowns, 1>(kControlUnknowns * static_cast<Index>(k), 0)));
        const double lower = cost(camera, there);
        if (lower < here) {
          here = lower, controls = std::move(there), taken = true;
          if (damping == 0 && promised < kSettled) return true;
          damping = damping < 1e-6 ? 0 : 0.1 * damping;
        }
      }
      if (!taken) damping = std::max(10 * damping, 1e-6);
    }
    if (!taken) return true;  // As low as rounding lets it go.
  }
  return true;
}

bool PathAdjustment::take_out_path(const RowCamera& camera, const std::vector<Control>& controls,
                                   const std::vector<Eigen::Matrix2d>& counted,
                                   MatrixXd& columns) const {
  std::vector<PathLook> all;
  if (!looks(camera, controls, all)) return false;
  for (size_t i = 0; i < counted.size(); ++i) {
    const auto at = 2 * static_cast<Index>(i);
    all[i].by_controls = (counted[i] * all[i].by_controls).eval();
    columns.middleRows<2>(at) = (counted[i] * columns.middleRows<2>(at)).eval();
  }
  Band band(controls.size());
  MatrixXd right =
      MatrixXd::Zero(kControlUnknowns * static_cast<Index>(controls.size()), columns.cols());
  for (size_t i = 0; i < all.size(); ++i) {
    const Index first = kControlUnknowns * static_cast<Index>(all[i].weights.first),
                count = kControlUnknowns * all[i].weights.count;
    band.add(first, all[i].by_controls.leftCols(count));
    right.middleRows(first, count) += all[i].by_controls.leftCols(count).transpose() *
                                      columns.middleRows(2 * static_cast<Index>(i), 2);
  }
  if (!band.factor(0)) return false;
  const MatrixXd follow = band.solve(right);
  for (size_t i = 0; i < all.size(); ++i) {
    const Index first = kControlUnknowns * static_cast<Index>(all[i].weights.first),
                count = kControlUnknowns * all[i].weights.count;
    columns.middleRows(2 * static_cast<Index>(i), 2) -=
        all[i].by_controls.leftCols(count) * follow.middleRows(first, count);
  }
  return true;
}

}  // namespace seam::measurement
