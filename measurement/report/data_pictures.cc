#include "measurement/report/data_pictures.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "measurement/report/columns/data_columns.h"
#include "measurement/report/report_plots.h"

namespace seam::measurement {
namespace {

using nlohmann::json;

constexpr size_t kMostTracks = 4;
constexpr size_t kMostPoints = 800;   // Of a line.
constexpr size_t kMostArrows = 1200;  // Of a map.

// A channel's residuals by row; NaN where none was scored.
std::vector<double> by_row(const ResidualView& view, const std::string& channel, size_t rows) {
  std::vector<double> values(rows, NAN);
  if (const ResidualView::Channel* found = view.channel(channel)) {
    for (size_t i = 0; i < found->row.size(); ++i) values[found->row[i]] = found->residual[i];
  }
  return values;
}

// The rows of each track that have a residual, in time.
std::vector<std::vector<int>> tracks_of(const DataColumns& data,
                                        const std::vector<double>& residual) {
  const std::vector<double>&track = data.at("track"), &time = data.at("time_s");
  std::map<double, std::vector<int>> tracks;
  for (size_t row = 0; row < residual.size(); ++row) {
    if (std::isfinite(residual[row])) tracks[track[row]].push_back(static_cast<int>(row));
  }
  std::vector<std::vector<int>> all;
  for (auto& [number, rows] : tracks) {
    std::stable_sort(rows.begin(), rows.end(), [&](int a, int b) { return time[a] < time[b]; });
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

void append_servo_tracks(const DataColumns& data, const ResidualView& before,
                         const ResidualView* after, json& plots) {
  const std::string channel = "measured_rad";
  const std::vector<double>&measured = data.at(channel), &command = data.at("command_rad"),
        &time = data.at("time_s");
  const std::vector<double> residual = by_row(before, channel, time.size());
  const std::vector<double> predicted = minus(measured, residual);
  const std::vector<double> found =
      after ? minus(measured, by_row(*after, channel, time.size())) : std::vector<double>();
  for (const std::vector<int>& rows : some_tracks(tracks_of(data, residual), residual)) {
    json lines = {line_of("command", rows, time, command),
                  line_of("measured", rows, time, measured),
                  line_of("predicted", rows, time, predicted)};
    if (after) lines.push_back(line_of("predicted after", rows, time, found));
    plots["series"].push_back({{"title", data.name("track", rows[0])},
                               {"x", "time_s"},
                               {"y", channel},
                               {"rms", six_digits(root_mean_square(rows, residual))},
                               {"lines", std::move(lines)}});
  }
}

void append_walks(const DataColumns& data, const ResidualView& before, const ResidualView* after,
                  json& plots) {
  const std::vector<double>&x = data.at("x_m"), &y = data.at("y_m");
  const size_t n = x.size();
  std::vector<double> dx = by_row(before, "x_m", n), dy = by_row(before, "y_m", n), off(n, NAN);
  for (size_t i = 0; i < n; ++i) off[i] = std::hypot(dx[i], dy[i]);
  for (const std::vector<int>& rows : some_tracks(tracks_of(data, off), off)) {
    json lines = {line_of("measured", rows, x, y),
                  line_of("predicted", rows, minus(x, dx), minus(y, dy))};
    if (after)
      lines.push_back(line_of("predicted after", rows, minus(x, by_row(*after, "x_m", n)),
                              minus(y, by_row(*after, "y_m", n))));
    plots["series"].push_back({{"title", data.name("track", rows[0]) + " from above"},
                               {"x", "x_m"},
                               {"y", "y_m"},
                               {"plane", "world_m"},
                               {"rms", six_digits(root_mean_square(rows, off))},
                               {"lines", std::move(lines)}});
  }
}

// At each landmark the residuals of its observations, along and across the line of sight.
void append_landmarks(const DataColumns& data, const ResidualView& view, const std::string& stage,
                      json& plots) {
  const std::vector<double>&mark_x = data.at("landmark_x_m"), &mark_y = data.at("landmark_y_m"),
        &robot_x = data.at("robot_x_m"), &robot_y = data.at("robot_y_m");
  const std::vector<double> range = by_row(view, "range_m", mark_x.size());
  const std::vector<double> bearing = by_row(view, "bearing_rad", mark_x.size());
  std::vector<size_t> scored;
  for (size_t row = 0; row < mark_x.size(); ++row) {
    if (std::isfinite(range[row]) || std::isfinite(bearing[row])) scored.push_back(row);
  }
  json items = json::array(), robot = json::array(), places = json::array();
  for (const size_t i : some_of(scored.size(), kMostArrows)) {
    const size_t row = scored[i];
    const double to_x = mark_x[row] - robot_x[row], to_y = mark_y[row] - robot_y[row];
    const double distance = std::hypot(to_x, to_y);
    if (!(distance > 0)) continue;
    const double along = std::isfinite(range[row]) ? range[row] / distance : 0;
    const double across = std::isfinite(bearing[row]) ? bearing[row] : 0;
    items.push_back({six_digits(mark_x[row]), six_digits(mark_y[row]),
                     six_digits(along * to_x - across * to_y),
                     six_digits(along * to_y + across * to_x)});
    robot.push_back({six_digits(robot_x[row]), six_digits(robot_y[row])});
  }
  if (items.empty()) return;
  for (const DataColumns::Place& place : data.places)
    places.push_back(
        {{"name", place.name}, {"x", six_digits(place.x)}, {"y", six_digits(place.y)}});
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
  const std::string kind = problem.facts().kind();
  if (kind != "joints" && kind != "odometry" && kind != "landmarks") return;
  const DataColumns data = data_columns(problem, set);
  if (kind == "joints") append_servo_tracks(data, before, after, plots);
  if (kind == "odometry") append_walks(data, before, after, plots);
  if (kind == "landmarks") {
    append_landmarks(data, before, "before", plots);
    if (after) append_landmarks(data, *after, "after", plots);
  }
}

}  // namespace seam::measurement
