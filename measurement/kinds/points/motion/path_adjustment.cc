#include "measurement/kinds/points/motion/path_adjustment.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <limits>

namespace seam::measurement {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;

namespace {

constexpr Index kEach = 6;          // Unknowns of a control.
constexpr Index kBand = 4 * kEach;  // Controls that act together are neighbours.

// Normal equations whose entries lie near the diagonal; their factor costs as much as it has
// entries.
class Band {
 public:
  explicit Band(size_t controls)
      : entries_(MatrixXd::Zero(kBand, kEach * static_cast<Index>(controls))) {}

  template <class Slopes>
  void add(Index first, const Slopes& slopes) {
    const MatrixXd square = slopes.transpose().lazyProduct(slopes);
    for (Index j = 0; j < square.cols(); ++j) {
      for (Index i = j; i < square.rows(); ++i) entries_(i - j, first + j) += square(i, j);
    }
  }

  bool factor(double damping) {
    // Controls that no point tells of stay where they are.
    double largest[kEach] = {};
    for (Index j = 0; j < entries_.cols(); ++j)
      largest[j % kEach] = std::max(largest[j % kEach], entries_(0, j));
    std::vector<Eigen::Triplet<double>> all;
    for (Index j = 0; j < entries_.cols(); ++j) {
      for (Index i = 0; i < kBand && i + j < entries_.cols(); ++i) {
        double value = entries_(i, j);
        if (i == 0) value += damping * value + 1e-10 * largest[j % kEach] + 1e-300;
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

// The row at which a point is seen is the fixed point of row -> row of its image at that instant.
effects::ImagePoint seen_at(const RowCamera& camera, const Stretch& stretch,
                            const std::vector<Control>& controls, const PathSighting& point,
                            double& instant_s) {
  constexpr int kSteps = 30;
  constexpr double kExact_px = 1e-6;
  const RowClock& clock = camera.clocks[static_cast<size_t>(point.camera)];
  effects::ImagePoint image;
  double v = point.v_px, previous_v = v, previous_f = 0;
  for (int step = 0; step < kSteps; ++step) {
    instant_s = point.stamp_s + clock.late_s + clock.line_delay_s * v;
    const PathPoint path = path_at(stretch, controls, instant_s, /*with_slopes=*/false);
    image =
        camera.cameras.project(path.R * point.p_T + path.middle_C, point.stamp_s, v, point.camera);
    const double f = image.v - v;
    if (!image.visible || clock.line_delay_s == 0 || std::abs(f) < kExact_px) break;
    const double slope = step == 0 || v == previous_v ? -1 : (f - previous_f) / (v - previous_v);
    previous_v = v, previous_f = f;
    v = std::abs(slope) > 0.1 ? v - f / slope : image.v;
  }
  return image;
}

}  // namespace

bool PathAdjustment::image(const RowCamera& camera, const std::vector<Control>& controls,
                           const PathSighting& point, Vector2d& uv) const {
  double instant_s = 0;
  const effects::ImagePoint image =
      seen_at(camera, layout_.of_frame(point.frame), controls, point, instant_s);
  uv = {image.u, image.v};
  return image.visible;
}

bool PathAdjustment::look(const RowCamera& camera, const std::vector<Control>& controls,
                          const PathSighting& point, Look& look) const {
  const Stretch& stretch = layout_.of_frame(point.frame);
  double instant_s = 0;
  const effects::ImagePoint here = seen_at(camera, stretch, controls, point, instant_s);
  if (!here.visible) return false;
  const PathPoint path = path_at(stretch, controls, instant_s, /*with_slopes=*/true);
  const Vec3 arm = path.R * point.p_T, p_C = arm + path.middle_C;
  Eigen::Matrix<double, 2, 3> by_C;
  const double h = 1e-6 * glm::length(p_C);
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 moved_C = p_C;
    moved_C[axis] += h;
    const effects::ImagePoint there =
        camera.cameras.project(moved_C, point.stamp_s, here.v, point.camera);
    if (!there.visible) return false;
    by_C.col(axis) << (there.u - here.u) / h, (there.v - here.v) / h;
  }
  // A point that moves to another row is seen at another instant.
  const Vec3 rate = glm::cross(path.turning, arm) + path.moving;
  const Vector2d rate_px = by_C * Eigen::Vector3d(rate.x, rate.y, rate.z);
  const double line_delay_s = camera.clocks[static_cast<size_t>(point.camera)].line_delay_s;
  const double share = 1 / (1 - line_delay_s * rate_px[1]);
  Eigen::Matrix2d follow;
  follow << 1, line_delay_s * rate_px[0] * share, 0, share;
  Eigen::Matrix3d cross;  // d p_C = turn x arm + shift.
  cross << 0, arm.z, -arm.y, -arm.z, 0, arm.x, arm.y, -arm.x, 0;
  const Vector2d weight(1 / point.sigma_u, 1 / point.sigma_v);
  const Eigen::Matrix<double, 2, 3> slopes = -(weight.asDiagonal() * (follow * by_C));
  look.weights = path.weights;
  look.slopes.setZero();
  for (int j = 0; j < path.weights.count; ++j) {
    look.slopes.middleCols<3>(kEach * j) = slopes * cross * path.turn_by_control[j];
    look.slopes.middleCols<3>(kEach * j + 3) = path.weights.weight[j] * slopes;
  }
  look.z = weight.cwiseProduct(Vector2d(point.u_px - here.u, point.v_px - here.v));
  return true;
}

bool PathAdjustment::looks(const RowCamera& camera, const std::vector<Control>& controls,
                           std::vector<Look>& all) const {
  all.resize(seen_.size());
  for (size_t i = 0; i < seen_.size(); ++i) {
    if (!look(camera, controls, seen_[i], all[i])) return false;
  }
  return true;
}

double PathAdjustment::cost_of(const std::vector<Look>& all) {
  double sum = 0;
  for (const Look& look : all) sum += look.z.squaredNorm();
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
  std::vector<Look> all;
  for (int step = 0; step < kSteps; ++step) {
    if (!looks(camera, controls, all)) return false;
    if (step == 0) here = cost_of(all);
    Band band(controls.size());
    MatrixXd right = MatrixXd::Zero(kEach * static_cast<Index>(controls.size()), 1);
    for (const Look& look : all) {
      const Index first = kEach * static_cast<Index>(look.weights.first),
                  count = kEach * look.weights.count;
      band.add(first, look.slopes.leftCols(count));
      right.middleRows(first, count) -= look.slopes.leftCols(count).transpose() * look.z;
    }
    bool taken = false;
    for (int attempt = 0; attempt < kAttempts && !taken; ++attempt) {
      if (band.factor(damping)) {
        const MatrixXd by = band.solve(right);
        const double promised = 0.5 * by.col(0).dot(right.col(0));
        if (promised < kEnough * (1 + 1e-6 * here)) return true;
        std::vector<Control> there;
        for (size_t k = 0; k < controls.size(); ++k)
          there.push_back(
              moved_control(controls[k], by.block<kEach, 1>(kEach * static_cast<Index>(k), 0)));
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
  std::vector<Look> all;
  if (!looks(camera, controls, all)) return false;
  for (size_t i = 0; i < counted.size(); ++i) {
    const auto at = 2 * static_cast<Index>(i);
    all[i].slopes = (counted[i] * all[i].slopes).eval();
    columns.middleRows<2>(at) = (counted[i] * columns.middleRows<2>(at)).eval();
  }
  Band band(controls.size());
  MatrixXd right = MatrixXd::Zero(kEach * static_cast<Index>(controls.size()), columns.cols());
  for (size_t i = 0; i < all.size(); ++i) {
    const Index first = kEach * static_cast<Index>(all[i].weights.first),
                count = kEach * all[i].weights.count;
    band.add(first, all[i].slopes.leftCols(count));
    right.middleRows(first, count) += all[i].slopes.leftCols(count).transpose() *
                                      columns.middleRows(2 * static_cast<Index>(i), 2);
  }
  if (!band.factor(0)) return false;
  const MatrixXd follow = band.solve(right);
  for (size_t i = 0; i < all.size(); ++i) {
    const Index first = kEach * static_cast<Index>(all[i].weights.first),
                count = kEach * all[i].weights.count;
    columns.middleRows(2 * static_cast<Index>(i), 2) -=
        all[i].slopes.leftCols(count) * follow.middleRows(first, count);
  }
  return true;
}

}  // namespace seam::measurement
