#include "measurement/kinds/joints/short_runs.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/fitting/parameter_space.h"
#include "measurement/numerics/damped_step.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/parallel_for.h"
#include "measurement/numerics/robust.h"

namespace seam::measurement {
namespace {

// Angle and rate at a row, from a parabola through those around it.
struct Seen {
  double q_rad = 0, w_radps = 0;
};

Seen seen_at(const JointLog& log, size_t k) {
  constexpr size_t kReach = 4;
  const size_t from = k >= kReach ? k - kReach : 0;
  const size_t to = std::min(log.time_s.size(), k + kReach + 1);
  const auto count = static_cast<Eigen::Index>(to - from);
  if (count < 4) return {log.measured_rad[k], 0};
  const double span_s = log.time_s[to - 1] - log.time_s[from];
  Eigen::MatrixXd powers(count, 3);
  Eigen::VectorXd angles(count);
  for (size_t i = from; i < to; ++i) {
    const double t = (log.time_s[i] - log.time_s[k]) / span_s;
    powers.row(static_cast<Eigen::Index>(i - from)) << 1, t, t * t;
    angles[static_cast<Eigen::Index>(i - from)] = log.measured_rad[i];
  }
  const Eigen::Vector3d c =
      solve_symmetric(powers.transpose() * powers, powers.transpose() * angles);
  return {c[0], c[1] / span_s};
}

}  // namespace

ShortRuns::ShortRuns(const JointLogs& set, const std::vector<char>& chosen, double length_s)
    : set_(set) {
  for (size_t i = 0; i < set.logs.size(); ++i) {
    if (chosen[i]) cut(set.logs[i], length_s);
  }
  for (const JointLog& stretch : stretches_) rows_ += stretch.rows.size();
}

void ShortRuns::cut(const JointLog& log, double length_s) {
  constexpr size_t kFewest = 6;  // Rows.
  const size_t n = log.time_s.size();
  for (size_t from = 0; from + kFewest <= n;) {
    size_t to = from + kFewest;
    while (to < n && log.time_s[to] < log.time_s[from] + length_s) ++to;
    if (n - to < kFewest) to = n;
    const auto part = [&](const auto& values) {
      return std::decay_t<decltype(values)>(values.begin() + static_cast<std::ptrdiff_t>(from),
                                            values.begin() + static_cast<std::ptrdiff_t>(to));
    };
    JointLog stretch{.joint = log.joint,
                     .role = log.role,
                     .rows = part(log.rows),
                     .time_s = part(log.time_s),
                     .command_rad = part(log.command_rad),
                     .measured_rad = part(log.measured_rad),
                     .enabled = part(log.enabled),
                     .kp = part(log.kp),
                     .voltage = part(log.voltage),
                     .warmer_k = part(log.warmer_k)};
    for (const auto& column : log.columns) stretch.columns.push_back(part(column));
    for (double& t : stretch.time_s) t -= log.time_s[from];
    if (from > 0) {
      const Seen seen = seen_at(log, from);
      stretch.measured_rad[0] = seen.q_rad;
      // One that begins at rest would wait for its first command, which acts already.
      stretch.start_radps = seen.w_radps != 0 ? seen.w_radps : 1e-9;
    } else {
      stretch.start_radps = log.start_radps;
    }
    stretches_.push_back(std::move(stretch));
    from = to;
  }
}

std::vector<double> ShortRuns::misses(const Model& model) const {
  std::vector<double> misses(rows_);
  std::vector<size_t> begins;
  size_t rows = 0;
  for (const JointLog& stretch : stretches_)
    begins.push_back(rows), rows += stretch.measured_rad.size();
  parallel_for(stretches_.size(), [&](size_t i) {
    const JointLog& stretch = stretches_[i];
    const auto angles =
        predict_joint_log(model, set_, stretch, stretch.measured_rad[0], stretch.start_radps);
    for (size_t k = 0; k < angles.size(); ++k)
      misses[begins[i] + k] = stretch.measured_rad[k] - angles[k];
  });
  return misses;
}

double ShortRuns::cost(const Model& model) const {
  double sum = 0;
  for (const double miss : misses(model)) sum += miss * miss;
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

Model ShortRuns::descend(Model model, const std::vector<Unknown>& unknowns) const {
  const ParameterSpace space(model, unknowns);
  const auto count = static_cast<Eigen::Index>(rows_);
  Eigen::VectorXd place = space.place(model);
  const auto cost_of = [](const std::vector<double>& list) {
    double sum = 0;
    for (const double miss : list) sum += miss * miss;
    return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
  };
  std::vector<double> here = misses(model);
  double cost = cost_of(here);
  if (rows_ == 0 || !std::isfinite(cost)) return model;
  const auto look = [&] {
    Eigen::MatrixXd jacobian(count, place.size());
    parallel_for(space.size(), [&](size_t at) {
      const auto i = static_cast<Eigen::Index>(at);
      double step = 1e-3 * std::max(space[at].scale, std::abs(place[i]));
      if (place[i] + step > space[at].max) step = -step;
      const auto there = misses(space.with(model, at, place[i] + step));
      for (Eigen::Index k = 0; k < count; ++k)
        jacobian(k, i) = (there[static_cast<size_t>(k)] - here[static_cast<size_t>(k)]) / step;
    });
    Parabola parabola =
        parabola_of(jacobian, Eigen::Map<const Eigen::VectorXd>(here.data(), count));
    parabola.held = space.box().held(place, parabola.gradient);
    return parabola;
  };
  const auto move = [&](const Eigen::VectorXd& by) {
    const Eigen::VectorXd next = space.box().inside(place + by);
    auto there = misses(space.at(model, next));
    const double lower = cost_of(there);
    if (!(lower < cost)) return false;
    place = next, here = std::move(there), cost = lower;
    model = space.at(model, place);
    return true;
  };
  constexpr double kEnough = 1e-3;  // Of the cost.
  constexpr int kSteps = 10;
  measurement::descend({.look = look,
                        .move = move,
                        .height = [&] { return 0.5 * cost; },
                        .worth = [&] { return Worth{.gain = 0.5 * kEnough * cost}; }},
                       {.start = 1e-3, .attempts = 6}, kSteps);
  return model;
}

}  // namespace seam::measurement
