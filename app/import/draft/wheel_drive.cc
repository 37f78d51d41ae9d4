#include "app/import/draft/wheel_drive.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/maths.h"

namespace seam::app {
namespace {

using Pair = std::array<double, 2>;

double seconds(int64_t from, int64_t to) {
  return 1e-9 * static_cast<double>(to - from);
}

// Sizes of counters that wrap around.
constexpr int kCounterBits[] = {8, 10, 12, 14, 15, 16, 24, 31, 32};
// A wheel turns at most so many times as far between rows as in nearly all of them.
constexpr double kJump = 5;

// The largest difference of a counter that is to be expected, of nearly all rows.
double largest_step(const Drive& drive, size_t wheel) {
  std::vector<double> steps;
  for (size_t k = 1; k < drive.rows.size(); ++k) {
    if (drive.begins[k]) continue;
    const double step = std::abs(drive.rows[k].value[wheel] - drive.rows[k - 1].value[wheel]);
    if (step > 0) steps.push_back(step);
  }
  if (steps.empty()) return 0;
  // A counter that wraps around does so in a few rows of a hundred at most.
  std::sort(steps.begin(), steps.end());
  return kJump * steps[(steps.size() - 1) * 9 / 10];
}

// What is left of a difference once the counter's wrap is undone; the difference itself where none
// explains it.
double unwrapped(double step, double largest) {
  if (std::abs(step) <= largest) return step;
  for (const int bits : kCounterBits) {
    const double whole = std::ldexp(1.0, bits);
    const double real = step > 0 ? step - whole : step + whole;
    if (std::abs(real) <= largest) return real;
  }
  return step;
}

std::string read_counter(Drive& drive) {
  size_t wraps = 0, resets = 0;
  const Pair largest = {largest_step(drive, 0), largest_step(drive, 1)};
  for (size_t k = 1; k < drive.rows.size(); ++k) {
    bool reset = false;
    for (size_t w = 0; w < 2; ++w) {
      const double now = drive.rows[k].value[w], before = drive.rows[k - 1].value[w];
      const double step = now - before, real = unwrapped(step, largest[w]);
      drive.since[k][w] = real;
      if (drive.begins[k] || std::abs(step) <= largest[w]) continue;
      // Where both would explain it, a counter that is near 0 without being full was reset.
      const bool near_zero = std::abs(now) <= largest[w];
      wraps += real != step;
      reset = reset || (real == step && near_zero);
    }
    if (!reset) continue;
    ++resets;
    drive.begins[k] = 1, drive.since[k] = {0, 0};
  }
  std::string changes;
  if (wraps > 0) changes = fmt::format("counters wrapped around {} times: undone", wraps);
  if (resets > 0)
    changes += fmt::format("{}counters were reset {} times: a run begins there",
                           changes.empty() ? "" : "; ", resets);
  return changes;
}

}  // namespace

std::string read_wheels(WheelReading reading, Drive& drive) {
  const size_t n = drive.rows.size();
  drive.since.assign(n, {0, 0});
  drive.begins.assign(n, 0);
  for (size_t k = 0; k < n; ++k)
    drive.begins[k] = k == 0 || drive.rows[k].run != drive.rows[k - 1].run;
  if (reading == WheelReading::counter) return read_counter(drive);
  for (size_t k = 0; k < n; ++k) {
    if (reading == WheelReading::each_row) {
      drive.since[k] = drive.rows[k].value;
      continue;
    }
    if (drive.begins[k]) continue;
    const double dt = seconds(drive.rows[k - 1].ns, drive.rows[k].ns);
    for (size_t w = 0; w < 2; ++w) {
      const double before = drive.rows[k - 1].value[w], now = drive.rows[k].value[w];
      drive.since[k][w] =
          dt * (reading == WheelReading::commanded_speed ? before : 0.5 * (before + now));
    }
  }
  return "";
}

bool pose_at(const Drive& drive, int64_t ns, PlanarPose& pose) {
  const std::vector<PlanarPose>& poses = drive.poses;
  const auto after = std::lower_bound(poses.begin(), poses.end(), ns,
                                      [](const PlanarPose& p, int64_t t) { return p.ns < t; });
  if (after == poses.end()) return false;
  if (after->ns == ns) {
    pose = *after;
    return true;
  }
  if (after == poses.begin()) return false;
  const PlanarPose &a = *(after - 1), &b = *after;
  if (b.ns - a.ns > drive.longest_gap_ns) return false;
  const double share = seconds(a.ns, ns) / seconds(a.ns, b.ns);
  pose = {ns, a.x_m + share * (b.x_m - a.x_m), a.y_m + share * (b.y_m - a.y_m),
          a.theta_rad + share * maths::wrap_angle(b.theta_rad - a.theta_rad)};
  return true;
}

std::vector<Stretch> stretches_of(const Drive& drive) {
  constexpr double kStretch_s = 0.5;
  std::vector<Stretch> found;
  PlanarPose from;
  bool open = false;
  Pair turned{};
  for (size_t k = 0; k < drive.rows.size(); ++k) {
    if (drive.begins[k]) open = false;
    for (size_t w = 0; w < 2; ++w) turned[w] += drive.since[k][w];
    PlanarPose to;
    if (!pose_at(drive, drive.rows[k].ns, to)) continue;
    if (open && seconds(from.ns, to.ns) < kStretch_s) continue;
    if (open) {
      Stretch one{.turn_rad = maths::wrap_angle(to.theta_rad - from.theta_rad), .wheels = turned};
      const double heading = from.theta_rad + 0.5 * one.turn_rad;
      one.forward_m =
          std::cos(heading) * (to.x_m - from.x_m) + std::sin(heading) * (to.y_m - from.y_m);
      found.push_back(one);
    }
    from = to, open = true, turned = {0, 0};
  }
  return found;
}

double not_told_by_wheels(const std::vector<Stretch>& stretches) {
  constexpr double kLeast = 1e-6;  // What is less is rounding.
  const auto n = static_cast<Eigen::Index>(stretches.size());
  if (n < 8) return 1;
  Eigen::MatrixXd wheels(n, 2), motion(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Stretch& s = stretches[static_cast<size_t>(i)];
    wheels.row(i) << s.wheels[0], s.wheels[1];
    motion.row(i) << s.forward_m, s.turn_rad;
  }
  double share = 1;
  for (Eigen::Index c = 0; c < 2; ++c) {
    const Eigen::VectorXd y = motion.col(c);
    const double whole = y.squaredNorm();
    if (!(whole > 0)) continue;
    const Eigen::VectorXd left = y - wheels * measurement::solve_any_rank(wheels, y);
    share *= std::max(kLeast, left.squaredNorm() / whole);
  }
  return share;
}

}  // namespace seam::app
