#include "measurement/kinds/points/motion/path.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace seam::measurement {
namespace {

// Frames further apart than so many knots say nothing of each other's motion.
constexpr double kLongestGap = 1.6;
constexpr int kCubic = 3;

Eigen::Quaterniond as_quaternion(const Eigen::Vector4d& q) {
  return {q[0], q[1], q[2], q[3]};
}

Eigen::Vector4d quaternion_of(const Mat3& R) {
  Eigen::Matrix3d m;
  for (int c = 0; c < 3; ++c) m.col(c) << R[c].x, R[c].y, R[c].z;
  const Eigen::Quaterniond q(m);
  return {q.w(), q.x(), q.y(), q.z()};
}

Vec3 as_vec3(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}

}  // namespace

PathLayout::PathLayout(const std::vector<double>& stamp_s, const std::vector<char>& takes_part,
                       double knot_s)
    : stretch_of_frame_(stamp_s.size(), -1) {
  std::vector<size_t> order;
  for (size_t frame = 0; frame < stamp_s.size(); ++frame) {
    if (takes_part[frame]) order.push_back(frame);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return stamp_s[a] < stamp_s[b]; });
  for (size_t i = 0; i < order.size();) {
    size_t end = i + 1;
    size_t instants = 1;  // Several frames may have one stamp.
    while (end < order.size() &&
           stamp_s[order[end]] - stamp_s[order[end - 1]] <= kLongestGap * knot_s) {
      instants += stamp_s[order[end]] > stamp_s[order[end - 1]];
      ++end;
    }
    Stretch stretch{.from_s = stamp_s[order[i]], .first = controls_};
    stretch.degree = std::min(kCubic, static_cast<int>(instants) - 1);
    const double span = stamp_s[order[end - 1]] - stretch.from_s;
    const auto most = instants - static_cast<size_t>(stretch.degree);  // No more than instants.
    const size_t steps = std::clamp<size_t>(
        static_cast<size_t>(std::ceil(span / knot_s * (1 - 1e-9))), 1, std::max<size_t>(1, most));
    if (span > 0) stretch.step_s = span / static_cast<double>(steps);
    stretch.controls = steps + static_cast<size_t>(stretch.degree);
    if (stretch.degree == 0) stretch.controls = 1;
    for (; i < end; ++i) stretch_of_frame_[order[i]] = static_cast<int>(stretches_.size());
    controls_ += stretch.controls;
    stretches_.push_back(stretch);
  }
}

PathLayout PathLayout::alone(const std::vector<double>& stamp_s,
                             const std::vector<char>& takes_part, double step_s,
                             const std::vector<double>& exposure_s) {
  PathLayout layout;
  layout.stretch_of_frame_.assign(stamp_s.size(), -1);
  for (size_t frame = 0; frame < stamp_s.size(); ++frame) {
    if (!takes_part[frame]) continue;
    layout.stretch_of_frame_[frame] = static_cast<int>(layout.stretches_.size());
    layout.stretches_.push_back({.from_s = stamp_s[frame],
                                 .step_s = step_s,
                                 .degree = 1,
                                 .first = layout.controls_,
                                 .controls = 2,
                                 .exposure_s = exposure_s.empty() ? 0 : exposure_s[frame]});
    layout.controls_ += 2;
  }
  return layout;
}

// Uniform B-splines by the recursion of Cox and de Boor; before the first knot and behind the last
// the outermost pieces go on.
ControlWeights weights_at(const Stretch& stretch, double t_s) {
  ControlWeights at{.first = stretch.first, .count = stretch.degree + 1};
  if (stretch.degree == 0) return at;
  const double x = (t_s - stretch.from_s) / stretch.step_s;
  const int pieces = static_cast<int>(stretch.controls) - stretch.degree;
  const int piece = std::clamp(static_cast<int>(std::floor(x)), 0, pieces - 1);
  const double u = x - piece;
  at.first += static_cast<size_t>(piece);
  if (stretch.degree == kCubic) {
    const double w = 1 - u, u2 = u * u, w2 = w * w, sixth = 1.0 / 6, per = 0.5 / stretch.step_s;
    const double weight[4] = {sixth * w2 * w, sixth * (4 - 6 * u2 + 3 * u2 * u),
                              sixth * (4 - 6 * w2 + 3 * w2 * w), sixth * u2 * u};
    const double rate[4] = {-per * w2, per * (3 * u2 - 4 * u), per * (4 * w - 3 * w2), per * u2};
    std::copy(weight, weight + 4, at.weight);
    std::copy(rate, rate + 4, at.rate);
    return at;
  }
  double lower[4] = {1, 0, 0, 0};
  for (int k = 1; k <= stretch.degree; ++k) {
    double next[4] = {0, 0, 0, 0};
    for (int j = 0; j <= k; ++j) {
      const double before = j > 0 ? lower[j - 1] : 0, here = j < k ? lower[j] : 0;
      next[j] = ((u + k - j) * before + (1 + j - u) * here) / k;
      if (k == stretch.degree) at.rate[j] = (before - here) / stretch.step_s;
    }
    std::copy(next, next + 4, lower);
  }
  std::copy(lower, lower + 4, at.weight);
  return at;
}

PathPoint path_at(const Stretch& stretch, const std::vector<Control>& controls, double t_s,
                  bool with_slopes) {
  PathPoint point{.weights = weights_at(stretch, t_s)};
  const ControlWeights& w = point.weights;
  Eigen::Vector4d sum = Eigen::Vector4d::Zero(), change = Eigen::Vector4d::Zero();
  for (int j = 0; j < w.count; ++j) {
    const Control& control = controls[w.first + static_cast<size_t>(j)];
    sum += w.weight[j] * control.q;
    point.middle_C += w.weight[j] * control.middle_C;
    if (!with_slopes) continue;
    change += w.rate[j] * control.q;
    point.moving += w.rate[j] * control.middle_C;
  }
  const double length = sum.norm();
  point.R =
      rotation_from_quaternion(sum[0] / length, sum[1] / length, sum[2] / length, sum[3] / length);
  if (!with_slopes) return point;
  const Eigen::Quaterniond back = as_quaternion(sum / length).conjugate();
  point.turning = as_vec3(2 / length * (as_quaternion(change) * back).vec());
  for (int j = 0; j < w.count; ++j) {
    // A turn d of the control by the left changes the sum by half of d * q, of which the part along
    // the sum goes in normalising.
    const Eigen::Quaterniond r = as_quaternion(controls[w.first + static_cast<size_t>(j)].q) * back;
    Eigen::Matrix3d cross;
    cross << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
    point.turn_by_control[j] = w.weight[j] / length * (r.w() * Eigen::Matrix3d::Identity() - cross);
  }
  return point;
}

PathPoint turning_path_at(const ReadTurns& turns, const Stretch& stretch,
                          const std::vector<Control>& controls, double t_s, bool with_slopes) {
  PathPoint point{.weights = weights_at(stretch, t_s)};
  const Control &first = controls[stretch.first], &second = controls[stretch.first + 1];
  const double* weight = point.weights.weight;
  const Mat3 turned = turns.between(stretch.from_s, t_s, stretch.exposure_s);
  point.R = turned * rotation_from_quaternion(first.q[0], first.q[1], first.q[2], first.q[3]);
  point.middle_C = turned * (weight[0] * first.middle_C + weight[1] * second.middle_C);
  if (!with_slopes) return point;
  const double* rate = point.weights.rate;
  point.turning = turns.rate(t_s, stretch.exposure_s);
  point.moving = glm::cross(point.turning, point.middle_C) +
                 turned * (rate[0] * first.middle_C + rate[1] * second.middle_C);
  for (int c = 0; c < 3; ++c) point.shift_by_shift.col(c) << turned[c].x, turned[c].y, turned[c].z;
  point.turn_by_control[0] = point.shift_by_shift;
  point.turn_by_control[1].setZero();
  return point;
}

Control moved_control(const Control& control, const Eigen::Matrix<double, 6, 1>& by) {
  const Eigen::Vector3d turn = by.head<3>();
  const double angle = turn.norm();
  const Eigen::Quaterniond step(angle > 0
                                    ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle))
                                    : Eigen::Quaterniond::Identity());
  const Eigen::Quaterniond q = (step * as_quaternion(control.q)).normalized();
  return {.q = {q.w(), q.x(), q.y(), q.z()},
          .middle_C = control.middle_C + Vec3(by[3], by[4], by[5])};
}

void store_controls(const std::vector<Control>& controls, std::vector<double>& values) {
  for (const Control& control : controls) {
    values.insert(values.end(), control.q.begin(), control.q.end());
    values.insert(values.end(), {control.middle_C.x, control.middle_C.y, control.middle_C.z});
  }
}

void stored_controls(const std::vector<double>& values, std::vector<Control>& controls) {
  size_t at = values.size() - kControlNumbers * controls.size();
  for (Control& control : controls) {
    const double* stored = &values[at];
    control.q << stored[0], stored[1], stored[2], stored[3];
    control.middle_C = Vec3(stored[4], stored[5], stored[6]);
    at += kControlNumbers;
  }
}

std::vector<Control> path_through(const PathLayout& layout, const std::vector<double>& stamp_s,
                                  const std::vector<Pose>& X_CW, const std::vector<char>& known,
                                  const Vec3& middle_W) {
  std::vector<Control> controls(layout.controls());
  std::vector<size_t> order(stamp_s.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return stamp_s[a] < stamp_s[b]; });
  for (const Stretch& stretch : layout.stretches()) {
    std::vector<double> times;
    std::vector<Control> seen;
    for (const size_t frame : order) {
      if (!layout.takes_part(frame) || &layout.of_frame(frame) != &stretch || !known[frame])
        continue;
      Control here{.q = quaternion_of(X_CW[frame].R), .middle_C = X_CW[frame] * middle_W};
      if (!seen.empty() && here.q.dot(seen.back().q) < 0) here.q = -here.q;  // The same rotation.
      times.push_back(stamp_s[frame]);
      seen.push_back(here);
    }
    for (size_t k = 0; k < stretch.controls && !seen.empty(); ++k) {
      // Where the control acts most.
      const double t =
          stretch.from_s + (static_cast<double>(k) - 0.5 * (stretch.degree - 1)) * stretch.step_s;
      const auto above = std::upper_bound(times.begin(), times.end(), t) - times.begin();
      const auto i = std::clamp<size_t>(static_cast<size_t>(above), 1, times.size()) - 1,
                 next = std::min(i + 1, times.size() - 1);
      const double wide = times[next] - times[i];
      const double share = wide > 0 ? std::clamp((t - times[i]) / wide, 0.0, 1.0) : 0;
      Control& control = controls[stretch.first + k];
      control.q = ((1 - share) * seen[i].q + share * seen[next].q).normalized();
      control.middle_C = (1 - share) * seen[i].middle_C + share * seen[next].middle_C;
    }
  }
  return controls;
}

}  // namespace seam::measurement
