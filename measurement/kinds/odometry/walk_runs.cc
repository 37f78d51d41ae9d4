// Reading walks, predicting them, and the noise of their poses.
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "measurement/kinds/odometry/odometry.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

bool same_command(const BodyVelocity& a, const BodyVelocity& b) {
  return a.vx_mps == b.vx_mps && a.vy_mps == b.vy_mps && a.omega_radps == b.omega_radps;
}

// Third differences of one channel over rows under one command, by run; the last row of a window
// may have another command, which acts after it.
std::vector<std::vector<double>> third_differences(const std::vector<WalkRun>& runs, int channel,
                                                   bool one_command) {
  std::vector<std::vector<double>> all;
  for (const WalkRun& run : runs) {
    std::vector<double> found;
    for (size_t k = 3; k < run.pose.size(); ++k) {
      const bool same = same_command(run.command[k - 3], run.command[k - 2]) &&
                        same_command(run.command[k - 2], run.command[k - 1]);
      if (one_command && !same) {
        found.push_back(NAN);
        continue;
      }
      double step[3];
      for (int i = 0; i < 3; ++i) {
        step[i] = run.pose[k - 2 + i][channel] - run.pose[k - 3 + i][channel];
        if (channel == 2) step[i] = maths::wrap_angle(step[i]);
        step[i] /= run.time_s[k - 2 + i] - run.time_s[k - 3 + i];
      }
      // For even time steps this is the third difference over dt; scaled back by the mean step.
      const double dt = (run.time_s[k] - run.time_s[k - 3]) / 3;
      found.push_back((step[2] - 2 * step[1] + step[0]) * dt);
    }
    all.push_back(std::move(found));
  }
  return all;
}

// Mean of a(k) a(k + lag) over all windows where both are there and not gross; NaN where none is.
double autocovariance(const std::vector<std::vector<double>>& all, size_t lag, double largest) {
  double sum = 0;
  size_t n = 0;
  for (const auto& run : all) {
    for (size_t k = 0; k + lag < run.size(); ++k) {
      if (!(std::abs(run[k]) < largest) || !(std::abs(run[k + lag]) < largest)) continue;
      sum += run[k] * run[k + lag];
      ++n;
    }
  }
  return n > 0 ? sum / static_cast<double>(n) : NAN;
}

// Splits the third differences' covariance into white noise (20, -15, 6, -1) r and a random walk
// (6, -4, 1, 0) q; returns r.
double white_variance(const std::vector<std::vector<double>>& all) {
  std::vector<double> sizes;
  for (const auto& run : all) {
    for (const double a : run) {
      if (std::isfinite(a)) sizes.push_back(std::abs(a));
    }
  }
  if (sizes.size() < 8) return NAN;
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2),
                   sizes.end());
  const double sigma = sizes[sizes.size() / 2] / 0.6745;
  const double clip = 4 * sigma;
  double g[4];
  for (size_t lag = 0; lag < 4; ++lag) g[lag] = autocovariance(all, lag, clip);
  const double only_white = g[0] / 20;
  if (!std::isfinite(g[1]) || !std::isfinite(g[2])) return only_white;
  // Least squares with equal weights for the lags; a random walk must show clearly.
  const double white[4] = {20, -15, 6, -1}, walk[4] = {6, -4, 1, 0};
  double ww = 0, wq = 0, qq = 0, wg = 0, qg = 0;
  for (size_t lag = 0; lag < (std::isfinite(g[3]) ? 4u : 3u); ++lag) {
    ww += white[lag] * white[lag], wq += white[lag] * walk[lag], qq += walk[lag] * walk[lag];
    wg += white[lag] * g[lag], qg += walk[lag] * g[lag];
  }
  const double det = ww * qq - wq * wq;
  const double r = (qq * wg - wq * qg) / det, q = (ww * qg - wq * wg) / det;
  const double spread = only_white * 12 / std::sqrt(static_cast<double>(sizes.size()));
  return q > 4 * spread && r > 0 ? r : only_white;
}

}  // namespace

std::vector<WalkRun> read_walk_runs(const CsvTable& table, const std::string& group_column,
                                    bool measured) {
  const auto times = table.times_ns("time_s");
  const auto vx = table.numbers("vx_cmd_mps"), vy = table.numbers("vy_cmd_mps"),
             omega = table.numbers("omega_cmd_radps");
  const auto names = table.texts(table.has("run") ? "run" : group_column);
  std::array<std::vector<double>, 3> pose;
  if (measured) pose = {table.numbers("x_m"), table.numbers("y_m"), table.numbers("theta_rad")};
  std::vector<WalkRun> runs;
  std::unordered_map<std::string, size_t> place;  // Only looked up.
  std::vector<int64_t> first_ns, last_ns;
  for (size_t row = 0; row < table.rows(); ++row) {
    for (const char* column : {"vx_cmd_mps", "vy_cmd_mps", "omega_cmd_radps"}) {
      const double value = column[1] == 'x' ? vx[row] : column[1] == 'y' ? vy[row] : omega[row];
      if (std::abs(value) > 100)
        table.fail(row, column, table.cell(row, column), "a velocity in m/s or rad/s");
    }
    const auto [found, is_new] = place.try_emplace(names[row], runs.size());
    if (is_new) {
      runs.push_back({.name = names[row]});
      first_ns.push_back(times[row]);
      last_ns.push_back(times[row] - 1);
    }
    const size_t i = found->second;
    if (times[row] <= last_ns[i]) {
      table.fail(row, "time_s", table.cell(row, "time_s"),
                 "a later time than the row before it in its run");
    }
    last_ns[i] = times[row];
    WalkRun& run = runs[i];
    run.rows.push_back(row);
    run.time_s.push_back(static_cast<double>(times[row] - first_ns[i]) * 1e-9);
    run.command.push_back({vx[row], vy[row], omega[row]});
    if (measured)
      run.pose.push_back({pose[0][row], pose[1][row], pose[2][row]});
    else
      run.pose.push_back({0, 0, 0});
  }
  return runs;
}

std::vector<effects::WalkState> predict_walk(const effects::Locomotion& walk, const WalkRun& run) {
  std::vector<effects::WalkState> path;
  path.reserve(run.rows.size());
  effects::WalkState state;
  for (size_t k = 0; k < run.rows.size(); ++k) {
    if (k > 0)
      effects::advance_walk(walk, run.command[k - 1], run.time_s[k] - run.time_s[k - 1], state);
    path.push_back(state);
  }
  return path;
}

std::array<double, 3> noise_of_walks(const std::vector<WalkRun>& runs) {
  double variance[3];
  for (int channel = 0; channel < 3; ++channel) {
    variance[channel] = white_variance(third_differences(runs, channel, true));
    if (!(variance[channel] > 0))
      variance[channel] = white_variance(third_differences(runs, channel, false));
    if (!(variance[channel] > 0)) variance[channel] = 1e-12;
  }
  const double xy = std::sqrt(0.5 * (variance[0] + variance[1]));
  return {xy, xy, std::sqrt(variance[2])};
}

}  // namespace seam::measurement
