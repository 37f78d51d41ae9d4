#include <algorithm>
#include <array>
#include <map>

#include "measurement/check/faults.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

using Times = std::vector<int64_t>;

double seconds(int64_t ns) {
  return 1e-9 * static_cast<double>(ns);
}

// Steps of a log that is sampled at a rate: of its runs and joints, each for itself.
struct Steps {
  Times ns;
  std::vector<size_t> rows;  // At which each step ends.
};

Steps steps_of(const CsvTable& table) {
  const Times times = table.times_ns("time_s");
  std::map<std::string, size_t> last;
  Steps steps;
  for (size_t row = 0; row < table.rows(); ++row) {
    std::string key;
    for (const char* column : {"run", "joint"}) {
      if (table.has(column)) key += fmt::format("{} ", table.cell(row, column));
    }
    const auto before = last.find(key);
    if (before != last.end() && times[row] > times[before->second]) {
      steps.ns.push_back(times[row] - times[before->second]);
      steps.rows.push_back(row);
    }
    last[key] = row;
  }
  return steps;
}

// Of a log whose rows are this far apart at most.
void look_at(const CsvTable& table, int64_t longest_ns, std::vector<std::string>& found) {
  constexpr int64_t kShortest_ns = 1000;
  constexpr int64_t kJump = 50;
  const Steps steps = steps_of(table);
  if (steps.ns.size() < 10) return;
  const int64_t usual = median_of(steps.ns);
  if (usual > longest_ns || usual < kShortest_ns) {
    const char* unit = usual < kShortest_ns             ? "no seconds"
                       : usual / 1000 <= longest_ns     ? "milliseconds for seconds"
                       : usual / 1000'000 <= longest_ns ? "microseconds for seconds"
                                                        : "nanoseconds for seconds";
    found.push_back(fmt::format("{}:{}: column time_s: rows are {:.4g} s apart: {}", table.file(),
                                table.line(steps.rows[0]), seconds(usual), unit));
    return;
  }
  size_t jumps = 0, first = 0;
  for (size_t i = 0; i < steps.ns.size(); ++i) {
    if (steps.ns[i] > kJump * usual && jumps++ == 0) first = i;
  }
  if (jumps > 0)
    found.push_back(fmt::format(
        "{}:{}: the clock jumps by {:.4g} s where {:.4g} s are usual, {} such jumps in all",
        table.file(), table.line(steps.rows[first]), seconds(steps.ns[first]), seconds(usual),
        jumps));
}

// Frames further apart than the camera's period says, by what a unit makes of it.
void look_at_frames(const CsvTable& table, double period_s, std::vector<std::string>& found) {
  const Times times = table.times_ns("time_s");
  Times steps;
  size_t row = 0;
  for (size_t i = 1; i < times.size(); ++i) {
    if (times[i] > times[i - 1]) steps.push_back(times[i] - times[i - 1]), row = row ? row : i;
  }
  if (steps.size() < 3) return;
  const double ratio = seconds(*std::min_element(steps.begin(), steps.end())) / period_s;
  for (const auto& [factor, unit] :
       {std::pair{1e3, "milliseconds"}, {1e6, "microseconds"}, {1e9, "nanoseconds"}}) {
    if (ratio > 0.5 * factor && ratio < 50 * factor)
      found.push_back(fmt::format(
          "{}:{}: column time_s: frames are {:.4g} s apart where the camera's period is {:.4g} s: "
          "{} for seconds",
          table.file(), table.line(row), ratio * period_s, period_s, unit));
  }
}

// An exposure that lasts far longer than until the next frame.
void look_at_exposures(const CsvTable& table, std::vector<std::string>& found) {
  constexpr double kFarLonger = 20;
  const Times times = table.times_ns("time_s");
  const std::vector<double> exposures = table.numbers("exposure_s");
  size_t longest = times.size();
  double most = kFarLonger, step_s = 0;
  for (size_t row = 0; row + 1 < times.size(); ++row) {
    const double step = seconds(times[row + 1] - times[row]);
    if (!(step > 0) || exposures[row] < most * step) continue;
    most = exposures[row] / step, longest = row, step_s = step;
  }
  if (longest == times.size()) return;
  found.push_back(
      fmt::format("{}:{}: exposure_s is {:g} s, and the next frame {:.4g} s later: {} for seconds?",
                  table.file(), table.line(longest), exposures[longest], step_s,
                  most > 2000 ? "microseconds" : "milliseconds"));
}

// Whether nearly all of these times lie within those of the log.
bool covered(const Times& times, int64_t divisor, int64_t begin, int64_t end) {
  const auto inside = std::count_if(times.begin(), times.end(), [&](int64_t t) {
    return t / divisor >= begin && t / divisor <= end;
  });
  return static_cast<size_t>(inside) * 10 > times.size() * 9;
}

void look_at_both(const CsvTable& seen, const CsvTable& log, std::vector<std::string>& found) {
  const Times times = seen.times_ns("time_s"), log_times = log.times_ns("time_s");
  if (times.size() < 2 || log_times.size() < 2) return;
  const auto [begin, end] = std::minmax_element(log_times.begin(), log_times.end());
  if (covered(times, 1, *begin, *end)) return;
  for (const auto& [divisor, unit] : std::array<std::pair<int64_t, const char*>, 3>{
           {{1000, "milliseconds"}, {1000'000, "microseconds"}, {1000'000'000, "nanoseconds"}}}) {
    if (covered(times, divisor, *begin, *end) && *end - *begin > 0)
      return found.push_back(fmt::format(
          "{}: column time_s lies within the times of {} where it is read as {}: {} for seconds",
          seen.file(), log.file(), unit, unit));
  }
}

}  // namespace

std::vector<std::string> faults_of_clocks(const MeasurementSet& set) {
  std::vector<std::string> found;
  try {
    constexpr int64_t kSecond_ns = 1'000'000'000;
    for (const auto& [name, longest_ns] : {std::pair{"joints", 2 * kSecond_ns},
                                           {"odometry", 5 * kSecond_ns},
                                           {"poses", 5 * kSecond_ns}}) {
      if (!set.has_file(name)) continue;
      const CsvTable table = set.table(name);
      if (table.has("time_s")) look_at(table, longest_ns, found);
    }
    if (set.has_file("frames")) {
      const CsvTable frames = set.table("frames");
      if (frames.has("time_s") && frames.has("exposure_s")) look_at_exposures(frames, found);
    }
    for (const char* seen : {"points", "observations", "frames"}) {
      if (set.has_file(seen) && set.camera.frame_period_s > 0 && set.table(seen).has("time_s"))
        look_at_frames(set.table(seen), set.camera.frame_period_s, found);
      for (const char* log : {"joints", "poses"}) {
        if (!set.has_file(seen) || !set.has_file(log)) continue;
        const CsvTable table = set.table(seen), other = set.table(log);
        if (table.has("time_s") && other.has("time_s")) look_at_both(table, other, found);
      }
    }
  } catch (const InputError&) {
    // What cannot be read is told where it is read to be used.
  }
  return found;
}

}  // namespace seam::measurement
