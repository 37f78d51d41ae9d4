#include "measurement/report/columns/data_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

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

// Which series a row belongs to, and the times since the series' first row.
void add_tracks(const MeasurementSet& set, const Facts& facts, const Table& table,
                DataColumns& data) {
  const std::vector<int>& series =
      facts.series_of_row.empty() ? facts.group_of_row : facts.series_of_row;
  std::map<int, std::pair<size_t, double>> number_and_start;  // In the order of rows.
  for (size_t row = 0; row < series.size(); ++row) {
    const auto [track, is_new] = number_and_start.try_emplace(
        series[row], data.names["track"].size(), facts.time_of_row[row]);
    track->second.second = std::min(track->second.second, facts.time_of_row[row]);
    if (!is_new) continue;
    std::string name = fmt::format("{} {}", set.group, facts.groups[facts.group_of_row[row]]);
    if (table.csv.has("joint"))
      name += fmt::format(", {}", table.csv.cell(table.row[row], "joint"));
    data.names["track"].push_back(std::move(name));
  }
  std::vector<double> track, time;
  for (size_t row = 0; row < series.size(); ++row) {
    const auto& [number, start] = number_and_start.at(series[row]);
    track.push_back(static_cast<double>(number));
    time.push_back(facts.time_of_row[row] - start);
  }
  data.columns.emplace_back("track", std::move(track));
  data.columns.emplace_back("time_s", std::move(time));
}

// From where each landmark was seen, and where it is.
void add_sights(const MeasurementSet& set, const Table& table, DataColumns& data) {
  const CsvTable marks = set.table("landmarks");
  const std::vector<double> mark_x = marks.numbers("x_m"), mark_y = marks.numbers("y_m");
  std::map<std::string, size_t> place_of;
  for (size_t i = 0; i < marks.rows(); ++i) {
    const std::string name(marks.cell(i, "landmark"));
    place_of[name] = i;
    data.names["landmark"].push_back(name);
    data.places.push_back({name, mark_x[i], mark_y[i]});
  }
  const Ways ways(set.table("poses"));
  const std::vector<double> time = table.column("time_s");
  const size_t n = table.row.size();
  std::vector<double> landmark(n, NAN), landmark_x(n, NAN), landmark_y(n, NAN), robot_x(n, NAN),
      robot_y(n, NAN);
  for (size_t row = 0; row < n; ++row) {
    const size_t line = table.row[row];
    const auto mark = place_of.find(std::string(table.csv.cell(line, "landmark")));
    if (mark == place_of.end()) continue;
    const std::string run = table.csv.has("run") ? std::string(table.csv.cell(line, "run")) : "";
    landmark[row] = static_cast<double>(mark->second);
    landmark_x[row] = mark_x[mark->second], landmark_y[row] = mark_y[mark->second];
    std::tie(robot_x[row], robot_y[row]) = ways.at(run, time[row]);
  }
  data.columns = {{"landmark", std::move(landmark)},
                  {"landmark_x_m", std::move(landmark_x)},
                  {"landmark_y_m", std::move(landmark_y)},
                  {"robot_x_m", std::move(robot_x)},
                  {"robot_y_m", std::move(robot_y)}};
}

// Which number of whole runs a row is, with its error.
void add_outcomes(const Table& table, DataColumns& data) {
  for (const char* name : {"scenario", "value", "statistic"}) {
    std::vector<std::string> texts;
    for (const size_t line : table.row) texts.emplace_back(table.csv.cell(line, name));
    const std::vector<int> numbers = number_groups(texts, data.names[name]);
    data.columns.emplace_back(name, std::vector<double>(numbers.begin(), numbers.end()));
  }
  for (const char* name : {"measured", "sigma"})
    data.columns.emplace_back(name, table.column(name));
}

}  // namespace

const std::vector<double>& DataColumns::at(const std::string& name) const {
  const auto found = std::find_if(columns.begin(), columns.end(),
                                  [&](const auto& column) { return column.first == name; });
  SEAM_CHECK(found != columns.end(), "there is no column {}", name);
  return found->second;
}

std::string DataColumns::name(const std::string& column, int row) const {
  return names.at(column).at(static_cast<size_t>(at(column)[static_cast<size_t>(row)]));
}

DataColumns data_columns(const Problem& problem, const MeasurementSet& set) {
  const Facts& facts = problem.facts();
  const std::string kind = facts.kind();
  DataColumns data;
  const auto add = [&](const Table& table, std::initializer_list<const char*> names) {
    add_tracks(set, facts, table, data);
    for (const char* name : names) data.columns.emplace_back(name, table.column(name));
  };
  if (kind == "joints") add(Table(set.table("joints"), facts), {"measured_rad", "command_rad"});
  if (kind == "odometry") add(Table(set.table("odometry"), facts), {"x_m", "y_m"});
  if (kind == "landmarks") add_sights(set, Table(set.table("observations"), facts), data);
  if (kind == "outcomes") add_outcomes(Table(set.table("outcomes"), facts), data);
  return data;
}

}  // namespace seam::measurement
