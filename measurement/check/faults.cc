#include "measurement/check/faults.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

using Rows = std::vector<size_t>;
using Numbers = std::vector<double>;

// Of a ratio that is 1 in good data: what it looks like. Effects change it by tens of per cent.
constexpr double kDegrees = 180 / std::numbers::pi;

std::string unit_of_ratio(double ratio, double factor, const char* unit, const char* instead) {
  if (ratio > 0.6 * factor && ratio < 1.6 * factor) return fmt::format("{} for {}", unit, instead);
  return "";
}

double span_of(const Numbers& values) {
  if (values.empty()) return 0;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return *most - *least;
}

Numbers at(const Numbers& values, const Rows& rows) {
  Numbers some;
  for (const size_t row : rows) some.push_back(values[row]);
  return some;
}

// Rows by what stands in these columns, those that the table lacks left out, in the table's order.
std::map<std::string, Rows> rows_by(const CsvTable& table,
                                    const std::vector<std::string>& columns) {
  std::map<std::string, Rows> rows;
  for (size_t row = 0; row < table.rows(); ++row) {
    std::string key;
    for (const std::string& column : columns) {
      if (table.has(column))
        key += fmt::format("{}{} {}", key.empty() ? "" : ", ", column, table.cell(row, column));
    }
    rows[key].push_back(row);
  }
  return rows;
}

std::string place(const CsvTable& table, size_t row) {
  return fmt::format("{}:{}", table.file(), table.line(row));
}

bool has_all(const CsvTable& table, std::initializer_list<const char*> columns) {
  return std::all_of(columns.begin(), columns.end(),
                     [&](const char* column) { return table.has(column); });
}

// ---- joints

void joints(const MeasurementSet& set, std::vector<std::string>& found) {
  const CsvTable table = set.table("joints");
  if (!has_all(table, {"command_rad", "measured_rad"})) return;
  const Numbers commands = table.numbers_or_blank("command_rad");
  const Numbers angles = table.numbers_or_blank("measured_rad");
  size_t equal = 0, moved = 0;
  std::map<std::string, std::pair<size_t, std::string>> said;  // By sentence: how often, where.
  double command_span = 0, angle_span = 0;
  for (const auto& [name, rows] : rows_by(table, {"run", "joint"})) {
    Numbers command = at(commands, rows), angle = at(angles, rows);
    const auto blank = [](double value) { return std::isnan(value); };
    if (std::any_of(command.begin(), command.end(), blank) ||
        std::any_of(angle.begin(), angle.end(), blank))
      continue;
    for (size_t i = 1; i < rows.size(); ++i) {
      if (angle[i] == angle[i - 1]) continue;
      ++moved;
      equal += command[i] == angle[i] ? 1 : 0;
    }
    command_span = std::max(command_span, span_of(command));
    angle_span = std::max(angle_span, span_of(angle));
    for (const std::string& sentence : faults_of_command(command, angle)) {
      auto& [count, where] = said[sentence];
      if (count++ == 0) where = fmt::format("{} ({})", place(table, rows[0]), name);
    }
  }
  if (moved >= 20 && equal * 10 > moved * 9)
    found.push_back(fmt::format(
        "{}: command_rad and measured_rad are equal in {} of {} rows in which the joint moves: the "
        "command column is really the measurement",
        table.file(), equal, moved));
  for (const auto& [sentence, where] : said)
    found.push_back(fmt::format("{}: {}{}", where.second, sentence,
                                where.first > 1 ? fmt::format(" ({} runs)", where.first) : ""));
  if (command_span == 0 || angle_span == 0) return;
  for (const auto& [ratio, column] : {std::pair{angle_span / command_span, "measured_rad"},
                                      {command_span / angle_span, "command_rad"}}) {
    if (const auto unit = unit_of_ratio(ratio, kDegrees, "degrees", "radians"); !unit.empty())
      found.push_back(fmt::format("{}: {} spans {:.0f} times as much as the other angle: {}",
                                  table.file(), column, ratio, unit));
  }
}

// ---- odometry

struct Walked {
  double measured_m = 0, commanded_m = 0;
  double measured_rad = 0, commanded_rad = 0;
};

// How far each run got from its start, and how far its commands would have.
Walked walked_in(const CsvTable& table) {
  const Numbers t = table.numbers("time_s"), vx = table.numbers("vx_cmd_mps");
  const Numbers vy = table.numbers("vy_cmd_mps"), omega = table.numbers("omega_cmd_radps");
  const Numbers x = table.numbers_or_blank("x_m"), y = table.numbers_or_blank("y_m");
  const Numbers theta = table.numbers_or_blank("theta_rad");
  Walked walked;
  for (const auto& [name, rows] : rows_by(table, {"run"})) {
    double px = 0, py = 0, heading = 0, far = 0, turn = 0, far_seen = 0, turn_seen = 0,
           before = NAN;
    double seen = 0;
    size_t first = rows[0];
    for (const size_t row : rows) {
      if (row != rows[0]) {
        const size_t last = row - 1;
        const double dt = t[row] - t[last];
        px += dt * (vx[last] * std::cos(heading) - vy[last] * std::sin(heading));
        py += dt * (vx[last] * std::sin(heading) + vy[last] * std::cos(heading));
        heading += dt * omega[last];
      }
      far = std::max(far, std::hypot(px, py)), turn = std::max(turn, std::abs(heading));
      if (std::isnan(x[row]) || std::isnan(y[row]) || std::isnan(theta[row])) continue;
      if (std::isnan(before)) first = row;
      far_seen = std::max(far_seen, std::hypot(x[row] - x[first], y[row] - y[first]));
      if (!std::isnan(before)) {
        // Headings may be wrapped, by whatever turn they are counted in.
        const double step = theta[row] - before;
        seen += std::abs(step) > 180 ? step - std::copysign(360, step)
                : std::abs(step) > std::numbers::pi && std::abs(step) < 2.001 * std::numbers::pi
                    ? std::remainder(step, 2 * std::numbers::pi)
                    : step;
      }
      before = theta[row];
      turn_seen = std::max(turn_seen, std::abs(seen));
    }
    walked.measured_m += far_seen, walked.commanded_m += far;
    walked.measured_rad += turn_seen, walked.commanded_rad += turn;
  }
  return walked;
}

void walks(const MeasurementSet& set, std::vector<std::string>& found) {
  const CsvTable table = set.table("odometry");
  if (!has_all(table, {"time_s", "vx_cmd_mps", "vy_cmd_mps", "omega_cmd_radps", "x_m", "y_m",
                       "theta_rad"}))
    return;
  const Walked walked = walked_in(table);
  const auto tell = [&](double ratio, double factor, const char* columns, const char* verb,
                        const char* unit, const char* instead) {
    if (const auto text = unit_of_ratio(ratio, factor, unit, instead); !text.empty())
      found.push_back(fmt::format("{}: {} {} {:.0f} times as far as the other columns say: {}",
                                  table.file(), columns, verb, ratio, text));
  };
  if (walked.commanded_m > 0 && walked.measured_m > 0) {
    const double ratio = walked.measured_m / walked.commanded_m;
    tell(ratio, 1000, "x_m and y_m", "go", "millimetres", "metres");
    tell(1 / ratio, 1000, "vx_cmd_mps and vy_cmd_mps", "go", "millimetres", "metres");
  }
  if (walked.commanded_rad > 0.5 && walked.measured_rad > 0.5) {
    const double ratio = walked.measured_rad / walked.commanded_rad;
    tell(ratio, kDegrees, "theta_rad", "turns", "degrees", "radians");
    tell(1 / ratio, kDegrees, "omega_cmd_radps", "turns", "degrees", "radians");
  }
}

// ---- landmarks

struct Ranges {
  Numbers range, x, y;  // Where the robot was.
  Numbers beacon_x, beacon_y;

  // The median of | range - distance |, with x and y of the beacons as they stand or exchanged.
  double miss(bool exchanged) const {
    Numbers misses;
    for (size_t i = 0; i < range.size(); ++i)
      misses.push_back(std::abs(range[i] - distance(i, exchanged)));
    return median_of(misses);
  }
  double distance(size_t i, bool exchanged) const {
    const double bx = exchanged ? beacon_y[i] : beacon_x[i];
    const double by = exchanged ? beacon_x[i] : beacon_y[i];
    return std::hypot(bx - x[i], by - y[i]);
  }
};

Ranges ranges_of(const MeasurementSet& set, const CsvTable& seen) {
  const CsvTable places = set.table("landmarks"), poses = set.table("poses");
  std::map<std::string, size_t, std::less<>> beacon;
  for (size_t row = 0; row < places.rows(); ++row)
    beacon[std::string(places.cell(row, "landmark"))] = row;
  const Numbers bx = places.numbers("x_m"), by = places.numbers("y_m");
  const Numbers px = poses.numbers("x_m"), py = poses.numbers("y_m");
  const auto pose_times = poses.times_ns("time_s"), times = seen.times_ns("time_s");
  const Numbers range = seen.numbers_or_blank("range_m");
  const auto tracks = rows_by(poses, {"run"});
  Ranges found;
  for (size_t row = 0; row < seen.rows(); ++row) {
    const auto known = beacon.find(seen.cell(row, "landmark"));
    if (known == beacon.end() || std::isnan(range[row])) continue;
    const auto track = tracks.find(
        seen.has("run") && poses.has("run") ? fmt::format("run {}", seen.cell(row, "run")) : "");
    if (track == tracks.end()) continue;
    const Rows& rows = track->second;
    auto next = std::lower_bound(rows.begin(), rows.end(), times[row],
                                 [&](size_t r, int64_t t) { return pose_times[r] < t; });
    if (next == rows.end()) --next;
    found.range.push_back(range[row]);
    found.x.push_back(px[*next]), found.y.push_back(py[*next]);
    found.beacon_x.push_back(bx[known->second]), found.beacon_y.push_back(by[known->second]);
  }
  return found;
}

void landmarks(const MeasurementSet& set, std::vector<std::string>& found) {
  const CsvTable seen = set.table("observations");
  if (seen.has("bearing_rad")) {
    const Numbers bearings = seen.numbers_or_blank("bearing_rad");
    for (size_t row = 0; row < bearings.size(); ++row) {
      if (!(std::abs(bearings[row]) > 2 * std::numbers::pi)) continue;
      found.push_back(fmt::format("{}: bearing_rad is {:g}, more than a turn: degrees for radians",
                                  place(seen, row), bearings[row]));
      break;
    }
  }
  if (!seen.has("range_m")) return;
  const Ranges ranges = ranges_of(set, seen);
  if (ranges.range.size() < 20) return;
  Numbers ratios, distances;
  for (size_t i = 0; i < ranges.range.size(); ++i) {
    distances.push_back(ranges.distance(i, false));
    if (distances.back() > 0) ratios.push_back(ranges.range[i] / distances.back());
  }
  const double ratio = median_of(ratios);
  for (const auto& [of, columns] : {std::pair{ratio, "range_m"}, {1 / ratio, "the places"}}) {
    if (const auto unit = unit_of_ratio(of, 1000, "millimetres", "metres"); !unit.empty())
      found.push_back(
          fmt::format("{}: ranges are {:.4g} times the distances of the places: {} in {}",
                      seen.file(), ratio, unit, columns));
  }
  const double as_it_stands = ranges.miss(false), exchanged = ranges.miss(true);
  if (as_it_stands > 0.1 * median_of(distances) && 3 * exchanged < as_it_stands)
    found.push_back(fmt::format(
        "{}: ranges miss by {:.3g} m, and by {:.3g} m with x_m and y_m of the landmarks exchanged",
        set.table("landmarks").file(), as_it_stands, exchanged));
}

// ---- points

struct View {
  std::string name;
  Rows rows;
};

// The image of a flat target as an affine map: its handedness tells which side is seen.
double handedness(const Numbers& x, const Numbers& y, const Numbers& u, const Numbers& v,
                  const Rows& rows) {
  Eigen::MatrixXd a(rows.size(), 3);
  Eigen::MatrixXd b(rows.size(), 2);
  for (size_t i = 0; i < rows.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    a.row(row) << x[rows[i]], y[rows[i]], 1;
    b.row(row) << u[rows[i]], v[rows[i]];
  }
  const Eigen::MatrixXd map = a.colPivHouseholderQr().solve(b);
  return map(0, 0) * map(1, 1) - map(0, 1) * map(1, 0);
}

std::vector<View> views_of(const CsvTable& table, const std::string& group) {
  std::vector<View> views;
  for (size_t row = 0; row < table.rows(); ++row) {
    const std::string name(table.cell(row, table.has("frame") ? "frame" : group));
    if (views.empty() || views.back().name != name) views.push_back({name, {}});
    views.back().rows.push_back(row);
  }
  return views;
}

void points(const MeasurementSet& set, std::vector<std::string>& found) {
  constexpr size_t kFewest = 4;
  const CsvTable table = set.table("points");
  if (!has_all(table, {"u_px", "v_px", "x_m", "y_m", "z_m", "frame"})) return;
  const Numbers u = table.numbers("u_px"), v = table.numbers("v_px");
  const Numbers x = table.numbers("x_m"), y = table.numbers("y_m"), z = table.numbers("z_m");
  const bool flat = std::all_of(z.begin(), z.end(), [](double value) { return value == 0; });
  const bool held_before_it = set.root.has("rig") && set.root.at("rig").has("pose");
  const auto views = views_of(table, set.group);
  size_t mirrored = 0, repeated = 0, looked_at = 0;
  std::string first_mirrored, first_repeated;
  for (size_t i = 0; i < views.size(); ++i) {
    const Rows& rows = views[i].rows;
    if (rows.size() < kFewest) continue;
    if (flat && held_before_it) {
      ++looked_at;
      if (handedness(x, y, u, v, rows) < 0 && mirrored++ == 0) first_mirrored = views[i].name;
    }
    const auto same = [&](size_t a, size_t b) {
      return u[a] == u[b] && v[a] == v[b] && x[a] == x[b] && y[a] == y[b] && z[a] == z[b];
    };
    if (i > 0 &&
        std::equal(rows.begin(), rows.end(), views[i - 1].rows.begin(), views[i - 1].rows.end(),
                   same) &&
        repeated++ == 0)
      first_repeated = views[i].name;
  }
  if (repeated > 0)
    found.push_back(fmt::format(
        "{} views repeat the one before to the last digit, the first is {}: a frame that was "
        "stored twice",
        repeated, first_repeated));
  if (mirrored > 0 && mirrored < looked_at)
    found.push_back(fmt::format(
        "{} of {} views show the target mirrored against the others, the first is {}: its corners "
        "are numbered from another end there",
        mirrored, looked_at, first_mirrored));
}

}  // namespace

std::vector<std::string> faults_of_command(const std::vector<double>& command,
                                           const std::vector<double>& measured) {
  constexpr int kMostRows = 20;
  std::vector<std::string> found;
  const size_t n = command.size();
  const double span = span_of(command);
  if (n < 3 * kMostRows || span < 1e-9 || span_of(measured) < 1e-9 || command == measured)
    return found;
  // Root mean square of what stays when the command is held against the angle `lag` rows later.
  const auto miss = [&](int lag) {
    double sum = 0, mean = 0;
    size_t count = 0;
    for (size_t k = kMostRows; k + kMostRows < n; ++k) {
      const double d = measured[static_cast<size_t>(static_cast<int>(k) + lag)] - command[k];
      sum += d * d, mean += d, ++count;
    }
    const double m = mean / static_cast<double>(count);
    return std::sqrt(std::max(0.0, sum / static_cast<double>(count) - m * m));
  };
  int best = 0;
  for (int lag = -kMostRows; lag <= kMostRows; ++lag) {
    if (miss(lag) < miss(best)) best = lag;
  }
  // Later it may be: a servo that is late and else ideal.
  if (best >= 0) return found;
  if (miss(best) < 1e-6 * span) {
    found.push_back(
        fmt::format("the command is the measurement {} rows earlier: is it a copy of it?", -best));
  } else if (miss(best) < 0.7 * miss(0) && miss(best) < 0.7 * miss(-best)) {
    found.push_back(fmt::format(
        "the measured angle is {} rows ahead of the command: are the two columns exchanged?",
        -best));
  }
  return found;
}

std::vector<std::string> faults_of_values(const MeasurementSet& set) {
  std::vector<std::string> found;
  try {
    if (set.kind == "joints") joints(set, found);
    if (set.kind == "odometry") walks(set, found);
    if (set.kind == "landmarks") landmarks(set, found);
    if (set.kind == "points") points(set, found);
  } catch (const InputError&) {
    // What cannot be read is told where it is read to be used.
  }
  return found;
}

}  // namespace seam::measurement
