// Reading walks, predicting them, and the noise of their poses.
#include <algorithm>
#include <cmath>
#include <span>
#include <unordered_map>

#include "measurement/kinds/odometry/odometry.h"
#include "measurement/sets/further_columns.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// What a table says of the body's motion.
class Motion {
 public:
  explicit Motion(const CsvTable& table) : of_ticks_(has_ticks(table)) {
    if (of_ticks_) {
      for (const char* column : kTickColumns) columns_.push_back(table.numbers(column));
      return;
    }
    for (const char* column : kCommandColumns) {
      columns_.push_back(table.numbers(column));
      for (size_t row = 0; row < table.rows(); ++row) {
        if (std::abs(columns_.back()[row]) > 100)
          table.fail(row, column, table.cell(row, column), "a velocity in m/s or rad/s");
      }
    }
  }

  bool of_ticks() const { return of_ticks_; }
  BodyVelocity command(size_t row) const {
    return {columns_[0][row], columns_[1][row], columns_[2][row]};
  }
  std::array<double, 2> ticks(size_t row) const { return {columns_[0][row], columns_[1][row]}; }

 private:
  bool of_ticks_;
  std::vector<std::vector<double>> columns_;
};

// Poses may have gaps: cells that are blank, single ones or a whole column.
std::array<std::vector<double>, 3> read_poses(const CsvTable& table, bool measured) {
  std::array<std::vector<double>, 3> pose;
  size_t count = 0;
  for (size_t c = 0; c < 3; ++c) {
    if (!measured) {
      pose[c].assign(table.rows(), 0);
      continue;
    }
    pose[c] = table.numbers_or_blank(kPoseColumns[c]);
    for (const double value : pose[c]) count += !std::isnan(value);
  }
  if (measured && count == 0)
    throw InputError(fmt::format("{}: found no value in columns {}, {} and {}, expected poses",
                                 table.file(), kPoseColumns[0], kPoseColumns[1], kPoseColumns[2]));
  return pose;
}

// Third differences of one channel over rows under one command, by run; the last row of a window
// may have another command, which acts after it. Rows without a pose are passed over. Ticks are
// another from row to row: with them each window counts, the body being too slow to turn in one.
std::vector<std::vector<double>> third_differences(const std::vector<WalkRun>& runs, int channel,
                                                   bool one_command) {
  std::vector<std::vector<double>> all;
  for (const WalkRun& run : runs) {
    std::vector<size_t> seen;
    for (size_t k = 0; k < run.pose.size(); ++k) {
      if (!std::isnan(run.pose[k][channel])) seen.push_back(k);
    }
    // By row, the first of those that have its command.
    std::vector<size_t> since(run.command.size(), 0);
    for (size_t k = 1; k < since.size(); ++k)
      since[k] = run.command[k - 1] == run.command[k] ? since[k - 1] : k;
    std::vector<double> found;
    for (size_t n = 3; n < seen.size(); ++n) {
      const size_t first = seen[n - 3], last = seen[n];
      if (one_command && !since.empty() && since[last - 1] > first) {
        found.push_back(NAN);
        continue;
      }
      double step[3];
      for (size_t i = 0; i < 3; ++i) {
        const size_t from = seen[n - 3 + i], to = seen[n - 2 + i];
        step[i] = run.pose[to][channel] - run.pose[from][channel];
        if (channel == 2) step[i] = maths::wrap_angle(step[i]);
        step[i] /= run.time_s[to] - run.time_s[from];
      }
      // For even time steps this is the third difference over dt; scaled back by the mean step.
      const double dt = (run.time_s[last] - run.time_s[first]) / 3;
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
// (6, -4, 1, 0) q; returns r. The two look much alike: a motion capture whose errors last for two
// or three rows would pass for a walk and leave hardly any noise, so that `walks` false takes all
// for noise.
double white_variance(const std::vector<std::vector<double>>& all, bool walks) {
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
  if (!walks || !std::isfinite(g[1]) || !std::isfinite(g[2])) return only_white;
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

bool has_ticks(const CsvTable& table) {
  return table.has(kTickColumns[0]) || table.has(kTickColumns[1]);
}

std::vector<std::string> walk_columns(const std::string& group_column) {
  std::vector<std::string> known = {"run", "time_s", group_column};
  for (const auto& names :
       {std::span<const char* const>(kPoseColumns), std::span<const char* const>(kCommandColumns),
        std::span<const char* const>(kTickColumns)})
    known.insert(known.end(), names.begin(), names.end());
  return known;
}

std::vector<WalkRun> read_walk_runs(const CsvTable& table, const std::string& group_column,
                                    bool measured, size_t* repeated) {
  const auto times = table.times_ns("time_s");
  const Motion motion(table);
  const auto names = table.texts(table.has("run") ? "run" : group_column);
  const std::array<std::vector<double>, 3> pose = read_poses(table, measured);
  const auto further = std::make_shared<const effects::FurtherColumns>(
      further_columns(table, walk_columns(group_column)));
  std::vector<WalkRun> runs;
  std::unordered_map<std::string, size_t> place;  // Only looked up.
  std::vector<int64_t> first_ns, last_ns;
  std::vector<std::array<double, 2>> carried;  // Ticks of rows that do not count.
  for (size_t row = 0; row < table.rows(); ++row) {
    const auto [found, is_new] = place.try_emplace(names[row], runs.size());
    if (is_new) {
      runs.push_back({.name = names[row], .further = further});
      first_ns.push_back(times[row]);
      last_ns.push_back(times[row] - 1);
      carried.push_back({0, 0});
    }
    const size_t i = found->second;
    if (times[row] < last_ns[i]) {
      table.fail(row, "time_s", table.cell(row, "time_s"),
                 "a later time than the row before it in its run");
    }
    const bool again = times[row] == last_ns[i];
    last_ns[i] = times[row];
    if (motion.of_ticks()) {
      const auto ticks = motion.ticks(row);
      carried[i] = {carried[i][0] + ticks[0], carried[i][1] + ticks[1]};
    }
    if (again) {
      if (repeated) ++*repeated;
      continue;
    }
    WalkRun& run = runs[i];
    run.rows.push_back(row);
    run.time_s.push_back(static_cast<double>(times[row] - first_ns[i]) * 1e-9);
    if (motion.of_ticks()) {
      run.ticks.push_back(carried[i]);
      carried[i] = {0, 0};
    } else {
      run.command.push_back(motion.command(row));
    }
    run.pose.push_back({pose[0][row], pose[1][row], pose[2][row]});
  }
  if (motion.of_ticks()) find_ways(runs);
  return runs;
}

namespace {

// What moves the body from a row to the next; ticks after the last row go on as they were.
class Drive {
 public:
  Drive(const effects::Locomotion& walk, const WalkRun& run, Ticks as)
      : walk_(walk),
        run_(run),
        in_time_(in_time(walk.tracker, run, as)),
        ticks_(in_time_.empty() ? ticks_of(run, as) : in_time_) {}

  void advance(size_t row, double dt_s, effects::WalkState& state) {
    if (run_.further) state.columns = {*run_.further, run_.rows[row]};
    if (!run_.slip_ticks.empty() && walk_.wheels.slip_s != 0)
      walk_.wheels.slips_in = by_ticks(run_.slip_ticks, row);
    effects::advance_walk(walk_, ticks_.empty() ? run_.command[row] : by_ticks(ticks_, row), dt_s,
                          state);
  }

 private:
  using TwoTicks = std::array<double, 2>;

  static const std::vector<TwoTicks>& ticks_of(const WalkRun& run, Ticks as) {
    return as == Ticks::rolled && !run.ways.empty() ? run.rolled_ticks : run.ticks;
  }
  static std::vector<TwoTicks> in_time(const effects::Tracker& tracker, const WalkRun& run,
                                       Ticks as) {
    std::vector<TwoTicks> ticks;
    if (tracker.right_late_s == 0 || run.ticks.empty()) return ticks;
    ticks = ticks_of(run, as);
    std::vector<double> right;
    for (const TwoTicks& both : ticks) right.push_back(both[1]);
    right = effects::read_in_time(right, run.time_s, tracker.right_late_s);
    for (size_t k = 0; k < right.size(); ++k) ticks[k][1] = right[k];
    return ticks;
  }
  BodyVelocity by_ticks(const std::vector<TwoTicks>& ticks, size_t row) const {
    const size_t to = std::min(row + 1, ticks.size() - 1);
    if (to == 0) return {};
    return walk_.wheels.velocity_of_ticks(ticks[to][0], ticks[to][1],
                                          run_.time_s[to] - run_.time_s[to - 1]);
  }

  effects::Locomotion walk_;
  const WalkRun& run_;
  const std::vector<TwoTicks> in_time_;  // Where one wheel's count is read later; else empty.
  const std::vector<TwoTicks>& ticks_;
};

}  // namespace

std::vector<effects::WalkState> predict_walk(const effects::Locomotion& walk, const WalkRun& run,
                                             const effects::Timing& timing, Ticks as) {
  std::vector<effects::WalkState> path;
  path.reserve(run.rows.size());
  effects::WalkState state;
  if (!run.pose.empty()) {
    const auto known = [&](int channel) {
      return std::isnan(run.pose[0][channel]) ? 0 : run.pose[0][channel];
    };
    state.from = {known(0), known(1), known(2)};
  }
  Drive drive(walk, run, as);
  for (size_t k = 0; k < run.rows.size(); ++k) {
    if (k > 0) drive.advance(k - 1, run.time_s[k] - run.time_s[k - 1], state);
    path.push_back(state);
  }
  std::vector<effects::WalkState> seen = path;
  for (size_t k = 0; k < path.size(); ++k) {
    const double late_s = timing.row_middle_after_stamp_s(0, run.time_s[k]);
    if (late_s == 0) continue;
    const double t = std::max(0.0, run.time_s[k] + late_s);
    const auto after = std::upper_bound(run.time_s.begin(), run.time_s.end(), t);
    const auto before = static_cast<size_t>(after - run.time_s.begin()) - 1;
    seen[k] = path[before];
    drive.advance(before, t - run.time_s[before], seen[k]);
  }
  if (!walk.tracker.is_axle()) {
    for (effects::WalkState& state : seen) {
      const auto point = walk.tracker.seen(state);
      state.x_m = point.x_m, state.y_m = point.y_m;
    }
  }
  return seen;
}

PoseSigmas pose_sigmas(const std::vector<effects::MovingNoise>& noise,
                       const std::array<double, 3>& of_set, const WalkRun& run,
                       const std::vector<effects::WalkState>& path) {
  PoseSigmas sigmas(path.size(), of_set);
  if (noise.empty()) return sigmas;
  for (size_t k = 0; k < path.size(); ++k) {
    // The run starts at rest.
    const double dt_s = k > 0 ? run.time_s[k] - run.time_s[k - 1] : 1;
    const double mps = k > 0 ? (path[k].path_m - path[k - 1].path_m) / dt_s : 0,
                 radps = k > 0 ? (path[k].theta_rad - path[k - 1].theta_rad) / dt_s : 0;
    for (const effects::MovingNoise& pose : noise) {
      const double growth = pose.growth(mps, radps);
      for (int channel = 0; channel < 3; ++channel) {
        const double more = growth * (channel == 2 ? pose.theta_sigma_rad : pose.xy_sigma_m);
        sigmas[k][channel] = std::sqrt(sigmas[k][channel] * sigmas[k][channel] + more * more);
      }
    }
  }
  return sigmas;
}

std::array<double, 3> noise_of_walks(const std::vector<WalkRun>& runs) {
  double variance[3];
  // Ticks have what the body walked in them, commands have not.
  const bool walks = runs.empty() || runs.front().ticks.empty();
  for (int channel = 0; channel < 3; ++channel) {
    variance[channel] = white_variance(third_differences(runs, channel, true), walks);
    if (!(variance[channel] > 0))
      variance[channel] = white_variance(third_differences(runs, channel, false), walks);
    if (!(variance[channel] > 0)) variance[channel] = 1e-12;
  }
  const double xy = std::sqrt(0.5 * (variance[0] + variance[1]));
  return {xy, xy, std::sqrt(variance[2])};
}

}  // namespace seam::measurement
