#include "measurement/report/data_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "measurement/report/report_plots.h"

namespace seam::measurement {
namespace {

using nlohmann::json;

constexpr size_t kMostTracks = 4;
constexpr size_t kMostPoints = 800;   // Of a line.
constexpr size_t kMostArrows = 1200;  // Of a map.

// The observations' table, by the rows of the problem.
struct Table {
  explicit Table(CsvTable read, const Facts& facts) : csv(std::move(read)) {
    std::map<int, size_t> row_at;
    for (size_t row = 0; row < csv.rows(); ++row) row_at[csv.line(row)] = row;
    for (const int line : facts.line_of_row) row.push_back(row_at.at(line));
  }

  // A column by the problem's rows; NaN for blank cells and where the table lacks it.
  std::vector<double> column(const std::string& name) const {
    std::vector<double> values(row.size(), NAN);
    if (!csv.has(name)) return values;
    const std::vector<double> all = csv.numbers_or_blank(name);
    for (size_t i = 0; i < row.size(); ++i) values[i] = all[row[i]];
    return values;
  }

  CsvTable csv;
  std::vector<size_t> row;  // In the table.
};

// A channel's residuals by row; NaN where none was scored.
std::vector<double> by_row(const ResidualView& view, const std::string& channel, size_t rows) {
  std::vector<double> values(rows, NAN);
  if (const ResidualView::Channel* found = view.channel(channel)) {
    for (size_t i = 0; i < found->row.size(); ++i) values[found->row[i]] = found->residual[i];
  }
  return values;
}

// The rows of each series that have a residual, in time.
std::vector<std::vector<int>> tracks_of(const Facts& facts, const std::vector<double>& residual) {
  const std::vector<int>& series =
      facts.series_of_row.empty() ? facts.group_of_row : facts.series_of_row;
  std::map<int, std::vector<int>> tracks;
  for (size_t row = 0; row < residual.size(); ++row) {
    if (std::isfinite(residual[row])) tracks[series[row]].push_back(static_cast<int>(row));
  }
  std::vector<std::vector<int>> all;
  for (auto& [number, rows] : tracks) {
    std::stable_sort(rows.begin(), rows.end(),
                     [&](int a, int b) { return facts.time_of_row[a] < facts.time_of_row[b]; });
    if (rows.size() > 2) all.push_back(std::move(rows));
  }
  return all;
}

double root_mean_square(const std::vector<int>& rows, const std::vector<double>& residual) {
  double sum = 0;
  for (const int row : rows) sum += residual[row] * residual[row];
  return std::sqrt(sum / static_cast<double>(rows.size()));
}

// A few of them from the worst to the best, so that neither stands for all.
std::vector<std::vector<int>> some_tracks(std::vector<std::vector<int>> tracks,
                                          const std::vector<double>& residual) {
  std::stable_sort(tracks.begin(), tracks.end(), [&](const auto& a, const auto& b) {
    return root_mean_square(a, residual) > root_mean_square(b, residual);
  });
  if (tracks.size() <= kMostTracks) return tracks;
  std::vector<std::vector<int>> some;
  for (size_t i = 0; i < kMostTracks; ++i)
    some.push_back(tracks[i * (tracks.size() - 1) / (kMostTracks - 1)]);
  return some;
}

json line_of(const char* name, const std::vector<int>& rows, const std::vector<double>& x,
             const std::vector<double>& y) {
  const size_t step = (rows.size() + kMostPoints - 1) / kMostPoints;
  json points = json::array();
  for (size_t i = 0; i < rows.size(); i += step) {
    if (std::isfinite(x[rows[i]]) && std::isfinite(y[rows[i]]))
      points.push_back({six_digits(x[rows[i]]), six_digits(y[rows[i]])});
  }
  return {{"name", name}, {"points", std::move(points)}};
}

std::vector<double> minus(std::vector<double> values, const std::vector<double>& residual) {
  for (size_t i = 0; i < values.size(); ++i) values[i] -= residual[i];
  return values;
}

// Times from the beginning of each track.
std::vector<double> since_start(const Facts& facts, const std::vector<std::vector<int>>& tracks) {
  std::vector<double> time(facts.rows(), NAN);
  for (const std::vector<int>& rows : tracks) {
    for (const int row : rows) time[row] = facts.time_of_row[row] - facts.time_of_row[rows.front()];
  }
  return time;
}

std::string name_of(const MeasurementSet& set, const Facts& facts, int row) {
  return fmt::format("{} {}", set.group, facts.groups[facts.group_of_row[row]]);
}

void append_servo_tracks(const MeasurementSet& set, const Facts& facts, const Table& table,
                         const ResidualView& before, const ResidualView* after, json& plots) {
  const std::string channel = "measured_rad";
  const std::vector<double> measured = table.column(channel), command = table.column("command_rad");
  const std::vector<double> residual = by_row(before, channel, facts.rows());
  const auto tracks = some_tracks(tracks_of(facts, residual), residual);
  const std::vector<double> time = since_start(facts, tracks);
  const std::vector<double> predicted = minus(measured, residual);
  const std::vector<double> found =
      after ? minus(measured, by_row(*after, channel, facts.rows())) : std::vector<double>();
  for (const std::vector<int>& rows : tracks) {
    const std::string joint =
        table.csv.has("joint") ? std::string(table.csv.cell(table.row[rows[0]], "joint")) : "";
    json lines = {line_of("command", rows, time, command),
                  line_of("measured", rows, time, measured),
                  line_of("predicted", rows, time, predicted)};
    if (after) lines.push_back(line_of("predicted after", rows, time, found));
    plots["series"].push_back(
        {{"title", name_of(set, facts, rows[0]) + (joint.empty() ? "" : ", " + joint)},
         {"x", "time_s"},
         {"y", channel},
         {"rms", six_digits(root_mean_square(rows, residual))},
         {"lines", std::move(lines)}});
  }
}

void append_walks(const MeasurementSet& set, const Facts& facts, const Table& table,
                  const ResidualView& before, const ResidualView* after, json& plots) {
  const std::vector<double> x = table.column("x_m"), y = table.column("y_m");
  const size_t n = facts.rows();
  std::vector<double> dx = by_row(before, "x_m", n), dy = by_row(before, "y_m", n), off(n, NAN);
  for (size_t i = 0; i < n; ++i) off[i] = std::hypot(dx[i], dy[i]);
  for (const std::vector<int>& rows : some_tracks(tracks_of(facts, off), off)) {
    json lines = {line_of("measured", rows, x, y),
                  line_of("predicted", rows, minus(x, dx), minus(y, dy))};
    if (after)
      lines.push_back(line_of("predicted after", rows, minus(x, by_row(*after, "x_m", n)),
                              minus(y, by_row(*after, "y_m", n))));
    plots["series"].push_back({{"title", name_of(set, facts, rows[0]) + " from above"},
                               {"x", "x_m"},
                               {"y", "y_m"},
                               {"plane", "world_m"},
                               {"rms", six_digits(root_mean_square(rows, off))},
                               {"lines", std::move(lines)}});
  }
}

// Where the robot was, by run and time.
class Ways {
 public:
  explicit Ways(const CsvTable& poses) {
    const std::vector<double> t = poses.numbers("time_s"), x = poses.numbers("x_m"),
                              y = poses.numbers("y_m");
    const bool has_run = poses.has("run");
    for (size_t i = 0; i < poses.rows(); ++i)
      ways_[has_run ? std::string(poses.cell(i, "run")) : ""][t[i]] = {x[i], y[i]};
  }

  // Between the poses before and after; those of one way stand for every run.
  std::pair<double, double> at(const std::string& run, double time_s) const {
    const auto named = ways_.find(run);
    const auto& way = named == ways_.end() ? ways_.begin()->second : named->second;
    auto next = way.lower_bound(time_s);
    if (next == way.end()) return way.rbegin()->second;
    if (next == way.begin()) return next->second;
    const auto last = std::prev(next);
    const double share = (time_s - last->first) / (next->first - last->first);
    return {last->second.first + share * (next->second.first - last->second.first),
            last->second.second + share * (next->second.second - last->second.second)};
  }

 private:
  std::map<std::string, std::map<double, std::pair<double, double>>> ways_;
};

// At each landmark the residuals of its observations, along and across the line of sight.
void append_landmarks(const MeasurementSet& set, const Facts& facts, const Table& table,
                      const ResidualView& view, const std::string& stage, json& plots) {
  const CsvTable marks = set.table("landmarks");
  const std::vector<double> mark_x = marks.numbers("x_m"), mark_y = marks.numbers("y_m");
  std::map<std::string, size_t> place_of;
  for (size_t i = 0; i < marks.rows(); ++i) place_of[std::string(marks.cell(i, "landmark"))] = i;
  const Ways ways(set.table("poses"));
  const std::vector<double> time = table.column("time_s");
  const std::vector<double> range = by_row(view, "range_m", facts.rows());
  const std::vector<double> bearing = by_row(view, "bearing_rad", facts.rows());
  std::vector<size_t> scored;
  for (size_t row = 0; row < facts.rows(); ++row) {
    if (std::isfinite(range[row]) || std::isfinite(bearing[row])) scored.push_back(row);
  }
  json items = json::array(), robot = json::array(), places = json::array();
  for (const size_t i : some_of(scored.size(), kMostArrows)) {
    const size_t row = scored[i], line = table.row[row];
    const auto mark = place_of.find(std::string(table.csv.cell(line, "landmark")));
    if (mark == place_of.end()) continue;
    const std::string run = table.csv.has("run") ? std::string(table.csv.cell(line, "run")) : "";
    const auto [x, y] = ways.at(run, time[row]);
    const double to_x = mark_x[mark->second] - x, to_y = mark_y[mark->second] - y;
    const double distance = std::hypot(to_x, to_y);
    if (!(distance > 0)) continue;
    const double along = std::isfinite(range[row]) ? range[row] / distance : 0;
    const double across = std::isfinite(bearing[row]) ? bearing[row] : 0;
    items.push_back({six_digits(mark_x[mark->second]), six_digits(mark_y[mark->second]),
                     six_digits(along * to_x - across * to_y),
                     six_digits(along * to_y + across * to_x)});
    robot.push_back({six_digits(x), six_digits(y)});
  }
  if (items.empty()) return;
  for (size_t i = 0; i < marks.rows(); ++i)
    places.push_back({{"name", marks.cell(i, "landmark")},
                      {"x", six_digits(mark_x[i])},
                      {"y", six_digits(mark_y[i])}});
  plots["arrows"].push_back({{"stage", stage},
                             {"plane", "world_m"},
                             {"unit", "m"},
                             {"items", std::move(items)},
                             {"robot", std::move(robot)},
                             {"places", std::move(places)}});
}

}  // namespace

void append_data_pictures(const Problem& problem, const MeasurementSet& set,
                          const ResidualView& before, const ResidualView* after, json& plots) {
  const Facts& facts = problem.facts();
  const std::string kind = facts.kind();
  const auto table = [&](const char* name) { return Table(set.table(name), facts); };
  if (kind == "joints") append_servo_tracks(set, facts, table("joints"), before, after, plots);
  if (kind == "odometry") append_walks(set, facts, table("odometry"), before, after, plots);
  if (kind == "landmarks") {
    const Table observations = table("observations");
    append_landmarks(set, facts, observations, before, "before", plots);
    if (after) append_landmarks(set, facts, observations, *after, "after", plots);
  }
}

}  // namespace seam::measurement
