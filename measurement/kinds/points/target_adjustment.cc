#include "measurement/kinds/points/target_adjustment.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "measurement/kinds/points/points_predictor.h"
#include "measurement/kinds/points/target/pose_solver.h"
#include "measurement/numerics/parallel_for.h"

namespace seam::measurement {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

double over_spread(double value, double spread) {
  return spread > 0 ? value / spread : 0;
}

}  // namespace

TargetAdjustment::Compiled::Compiled(const PointsData& data, const Model& model)
    : shape(effects::target_of(model)),
      camera(model, data.cameras, data.gyroscope.get()),
      places_W(places_of_rows(data, shape)) {
  if (data.rig.type() != Rig::Type::unknown)
    predictor = std::make_shared<const PointsPredictor>(data, model);
}

TargetAdjustment::TargetAdjustment(Given given)
    : given_(std::move(given)),
      compiled_(given_.data, given_.model),
      unknown_poses_(given_.data.rig.type() == Rig::Type::unknown) {
  const size_t frames = given_.data.rows_of_frame.size();
  state_.X_CW.resize(frames);
  state_.extra.resize(frames);
  state_.displaced_m.assign(given_.data.target.names.size(), Vec3(0.0));
}

// Of sways there are three of a shift and three of a turn.
double TargetAdjustment::spread_at(Index extra) const {
  const effects::TargetShape& shape = compiled_.shape;
  if (extra < motion_at()) return shape.focus_sigma;
  if (extra < sway_at(1)) return shape.motion_sigma_rad;
  return (extra - sway_at(1)) % 6 < 3 ? shape.sway_shift_sigma_m : shape.sway_turn_sigma_rad;
}

Index TargetAdjustment::unknowns(size_t frame) const {
  if (!given_.frames[frame]) return 0;
  return pose_unknowns() + state_.extra[frame].size();
}

std::vector<Index> TargetAdjustment::view_sizes() const {
  std::vector<Index> sizes;
  if (given_.path) {
    for (const Stretch& stretch : given_.path->stretches())
      sizes.push_back(kControlUnknowns * static_cast<Index>(stretch.controls));
    return sizes;
  }
  for (size_t frame = 0; frame < state_.X_CW.size(); ++frame) sizes.push_back(unknowns(frame));
  return sizes;
}

bool stored_path(const PointsData& data, const std::vector<double>& values,
                 std::vector<Control>& controls) {
  const size_t frames = data.rows_of_frame.size(), points = data.target.names.size();
  const size_t before = values.size() - kControlNumbers * controls.size();
  if (before != 12 * frames && before != 13 * frames + 3 * points) return false;
  stored_controls(values, controls);
  return true;
}

bool TargetAdjustment::start(const std::vector<double>& values) {
  const size_t frames = state_.X_CW.size(), points = state_.displaced_m.size();
  const auto drawn = static_cast<size_t>(causes_at() - focus_at(0));
  const size_t whole_size = 13 * frames + 3 * points;
  bool whole = values.size() >= whole_size;
  if (given_.path) {
    state_.controls.resize(given_.path->controls());
    if (!stored_path(given_.data, values, state_.controls)) return false;
    whole = values.size() == whole_size + kControlNumbers * state_.controls.size();
  }
  for (size_t frame = 0; frame < frames; ++frame) {
    if (has_own_poses() && given_.frames[frame] && !stored_pose(values, frame, state_.X_CW[frame]))
      given_.frames[frame] = 0;
    const Index causes = given_.causes.empty() ? 0 : given_.causes[frame].cols();
    state_.extra[frame] = Eigen::VectorXd::Zero(causes_at() + causes);
    if (whole && has_flex())
      state_.extra[frame][0] = values[12 * frames + frame] / compiled_.shape.flex_sigma_m;
    for (size_t i = 0; i < drawn && values.size() == whole_size + drawn * frames; ++i) {
      const Index at = focus_at(0) + static_cast<Index>(i);
      state_.extra[frame][at] = over_spread(values[whole_size + frame * drawn + i], spread_at(at));
    }
  }
  for (size_t point = 0; point < points && has_points(); ++point) {
    const Vector3d first = mean(point);
    state_.displaced_m[point] = Vec3(first[0], first[1], first[2]);
    if (!whole) continue;
    const double* stored = &values[13 * frames + 3 * point];
    state_.displaced_m[point] = Vec3(stored[0], stored[1], stored[2]);
  }
  return true;
}

std::vector<double> TargetAdjustment::values_of(const State& state) const {
  const size_t frames = state.X_CW.size();
  std::vector<double> values(12 * frames, 0);
  for (size_t frame = 0; frame < frames; ++frame) {
    if (has_own_poses() && given_.frames[frame]) store_pose(state.X_CW[frame], frame, values);
  }
  for (size_t frame = 0; frame < frames; ++frame)
    values.push_back(has_flex() && state.extra[frame].size() > 0
                         ? state.extra[frame][0] * compiled_.shape.flex_sigma_m
                         : 0);
  for (const Vec3& d : state.displaced_m) values.insert(values.end(), {d.x, d.y, d.z});
  for (size_t frame = 0; frame < frames; ++frame) {
    for (Index i = focus_at(0); i < causes_at(); ++i)
      values.push_back(state.extra[frame].size() > i ? state.extra[frame][i] * spread_at(i) : 0);
  }
  store_controls(state.controls, values);
  return values;
}

Matrix3d TargetAdjustment::precision(size_t point) const {
  if (given_.known) return given_.known->precision[point];
  const double sigma_m = compiled_.shape.scatter_sigma_m;
  return Matrix3d::Identity() / (sigma_m * sigma_m);
}

Vector3d TargetAdjustment::mean(size_t point) const {
  return given_.known ? given_.known->mean_m[point] : Vector3d::Zero();
}

double TargetAdjustment::prior_cost(const State& state) const {
  double sum = 0;
  for (size_t frame = 0; frame < state.extra.size(); ++frame) {
    if (given_.frames[frame]) sum += state.extra[frame].squaredNorm();
  }
  for (size_t point = 0; point < state.displaced_m.size() && has_points(); ++point) {
    const Vec3& d = state.displaced_m[point];
    const Vector3d away = Vector3d(d.x, d.y, d.z) - mean(point);
    sum += away.dot(precision(point) * away);
  }
  return 0.5 * sum;
}

// The frame's sum of squares.
double TargetAdjustment::square(const State& state, size_t frame) const {
  double sum = 0;
  size_t k = 0;
  for (const int r : given_.data.rows_of_frame[frame]) {
    const auto row = static_cast<size_t>(r);
    if (!given_.rows[row]) continue;
    Vector2d uv;
    if (!see(compiled_, state, row, uv)) return std::numeric_limits<double>::infinity();
    Vector2d left(given_.data.u_px[row] - uv[0], given_.data.v_px[row] - uv[1]);
    for (Index which = causes_at(); which < state.extra[frame].size(); ++which) {
      for (int c = 0; c < 2; ++c)
        left[c] -= cause(frame, k, c, which - causes_at()) * state.extra[frame][which];
    }
    for (int c = 0; c < 2; ++c) {
      const double z = left[c] / given_.sigma[2 * row + static_cast<size_t>(c)];
      sum += z * z;
    }
    ++k;
  }
  return sum;
}

double TargetAdjustment::cost(const State& state) const {
  std::vector<double> squares(state.X_CW.size(), 0);
  parallel_for(squares.size(), [&](size_t frame) {
    if (given_.frames[frame]) squares[frame] = square(state, frame);
  });
  return 0.5 * std::accumulate(squares.begin(), squares.end(), 0.0) + prior_cost(state);
}

// Looks at all used rows, each frame's in order.
bool TargetAdjustment::look_at_rows() {
  std::vector<size_t> first = {0};
  for (size_t frame = 0; frame < state_.X_CW.size(); ++frame) {
    const std::vector<int>& rows = given_.data.rows_of_frame[frame];
    const auto used = std::count_if(rows.begin(), rows.end(),
                                    [&](int row) { return given_.rows[static_cast<size_t>(row)]; });
    first.push_back(first.back() + (given_.frames[frame] ? static_cast<size_t>(used) : 0));
  }
  cells_.resize(first.back());
  std::vector<char> seen(state_.X_CW.size(), 1);
  parallel_for(seen.size(), [&](size_t frame) {
    if (!given_.frames[frame]) return;
    size_t k = 0;
    for (const int r : given_.data.rows_of_frame[frame]) {
      const auto row = static_cast<size_t>(r);
      if (!given_.rows[row] || !seen[frame]) continue;
      seen[frame] = look(state_, row, k, cells_[first[frame] + k]);
      ++k;
    }
  });
  return std::find(seen.begin(), seen.end(), 0) == seen.end();
}

void TargetAdjustment::hold_unseen_controls() {
  double largest[kControlUnknowns] = {};
  const size_t stretches = given_.path->stretches().size();
  const auto each = [&](auto&& act) {
    for (size_t view = 0; view < stretches; ++view) {
      for (Index i = 0; i < blocks_->of_view(view).rows(); ++i)
        act(view, i, largest[i % kControlUnknowns]);
    }
  };
  each([&](size_t view, Index i, double& most) {
    most = std::max(most, blocks_->of_view(view)(i, i));
  });
  each([&](size_t view, Index i, double most) {
    blocks_->add_prior(view, i, hold_of_control(most));
  });
}

// The normal equations where it stands, and their right sides (minus the gradient).
bool TargetAdjustment::build(MatrixXd& by_views, MatrixXd& by_points) {
  const size_t points = has_points() ? state_.displaced_m.size() : 0;
  blocks_ = std::make_unique<PairedBlocks>(view_sizes(), points);
  by_views = MatrixXd::Zero(blocks_->view_unknowns(), 1);
  by_points = MatrixXd::Zero(blocks_->point_unknowns(), 1);
  if (!look_at_rows()) return false;
  auto next = cells_.begin();
  for (size_t frame = 0; frame < state_.X_CW.size(); ++frame) {
    if (!given_.frames[frame]) continue;
    for (const int r : given_.data.rows_of_frame[frame]) {
      const auto row = static_cast<size_t>(r);
      if (!given_.rows[row]) continue;
      const Cell& cell = *next++;
      const auto point = static_cast<size_t>(given_.data.point_of_row[row]);
      const size_t view = view_of(frame);
      blocks_->add(view, cell.from, cell.by_view, point, cell.by_point);
      by_views.middleRows(blocks_->view_at(view) + cell.from, cell.by_view.cols()) -=
          cell.by_view.transpose() * cell.z;
      if (points > 0)
        by_points.middleRows<3>(3 * static_cast<Index>(point)) -=
            cell.by_point.transpose() * cell.z;
    }
    for (Index i = 0; i < state_.extra[frame].size(); ++i) {
      blocks_->add_prior(frame, pose_unknowns() + i, 1);
      by_views(blocks_->view_at(frame) + pose_unknowns() + i, 0) -= state_.extra[frame][i];
    }
  }
  if (given_.path) hold_unseen_controls();
  for (size_t point = 0; point < points; ++point) {
    blocks_->add_prior(point, precision(point));
    const Vec3& d = state_.displaced_m[point];
    by_points.middleRows<3>(3 * static_cast<Index>(point)) -=
        precision(point) * (Vector3d(d.x, d.y, d.z) - mean(point));
  }
  return true;
}

TargetAdjustment::State TargetAdjustment::moved(const MatrixXd& views, const MatrixXd& points,
                                                double by) const {
  State there = state_;
  for (size_t k = 0; k < there.controls.size(); ++k)
    there.controls[k] = moved_control(
        state_.controls[k],
        by * views.block<kControlUnknowns, 1>(kControlUnknowns * static_cast<Index>(k), 0));
  for (size_t frame = 0; frame < there.X_CW.size() && !given_.path; ++frame) {
    const Index at = blocks_->view_at(frame), size = unknowns(frame);
    if (size == 0) continue;
    if (unknown_poses_)
      there.X_CW[frame] = moved_pose(state_.X_CW[frame], by * views.block<6, 1>(at, 0));
    there.extra[frame] += by * views.block(at + pose_unknowns(), 0, size - pose_unknowns(), 1);
  }
  for (Index point = 0; 3 * point < points.rows(); ++point) {
    Vec3& d = there.displaced_m[static_cast<size_t>(point)];
    for (int axis = 0; axis < 3; ++axis) d[axis] += by * points(3 * point + axis, 0);
  }
  return there;
}

bool TargetAdjustment::fit(int most_steps) {
  constexpr int kAttempts = 10;
  // Of log-likelihood: less is not worth a step, and after a step that promised less than the
  // second, derivatives need no renewal.
  constexpr double kEnough = 1e-7, kSettled = 1e-4;
  double here = std::numeric_limits<double>::infinity(), damping = 0;
  for (int step = 0; step < most_steps; ++step) {
    MatrixXd right_views, right_points;
    if (!build(right_views, right_points)) return false;
    if (step == 0) {  // What was looked at for the derivatives tells the cost, too.
      here = prior_cost(state_);
      for (const Cell& cell : cells_) here += 0.5 * cell.z.squaredNorm();
    }
    bool taken = false;
    for (int attempt = 0; attempt < kAttempts && !taken; ++attempt) {
      MatrixXd views = right_views, points = right_points;
      if (blocks_->factor(damping)) {
        blocks_->solve(views, points);
        const double promised =
            0.5 * (views.col(0).dot(right_views.col(0)) + points.col(0).dot(right_points.col(0)));
        if (promised < kEnough * (1 + 1e-6 * here)) return true;
        State there = moved(views, points, 1);
        const double lower = cost(there);
        if (lower < here) {
          here = lower, state_ = std::move(there), taken = true;
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

std::vector<Matrix3d> TargetAdjustment::covariances() {
  MatrixXd views, points;
  if (!build(views, points) || !blocks_->factor(0)) return {};
  return blocks_->point_covariances();
}

}  // namespace seam::measurement
