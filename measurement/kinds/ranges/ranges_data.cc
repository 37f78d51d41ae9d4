#include "measurement/kinds/ranges/ranges_data.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

constexpr double kNearest_m = 0.05, kFarthest_m = 20;

// A measurement is gross where it is more than 6 robust sigmas, and a quarter of the distance, from
// the median of its place: a detector's own jumps by one pixel are smaller.
std::vector<char> gross(const std::vector<double>& measured,
                        const std::vector<std::vector<size_t>>& lines_of_place,
                        const std::vector<BallPlace>& places) {
  std::vector<char> flags(measured.size(), 0);
  for (size_t p = 0; p < places.size(); ++p) {
    std::vector<double> values, away;
    for (const size_t line : lines_of_place[p]) values.push_back(measured[line]);
    if (values.size() < 4) continue;
    const double middle = median_of(values);
    for (const double value : values) away.push_back(std::abs(value - middle));
    const double limit = std::max(6 * 1.4826 * median_of(away), 0.25 * places[p].true_m);
    for (const size_t line : lines_of_place[p])
      flags[line] = std::abs(measured[line] - middle) > limit;
  }
  return flags;
}

RangeRow row_of(size_t place, const std::vector<double>& values, size_t at_place) {
  RangeRow row{.place = place, .count = static_cast<int>(values.size())};
  const double n = static_cast<double>(values.size());
  for (const double value : values) row.mean_m += value / n;
  double square = 0;
  for (const double value : values) square += (value - row.mean_m) * (value - row.mean_m);
  if (values.size() > 1) row.spread_m = std::sqrt(square / (n - 1));
  row.share = n / static_cast<double>(at_place);
  return row;
}

struct Sides {
  std::vector<int> of_line;
  int count = 0;
  bool each_in_turn = false;  // Else side 0 is for training and side 1 held out.
};

// Nothing to hold out by: whole places are.
Sides sides_of(const CsvTable& table, const std::string& column,
               const std::vector<size_t>& place_of_line) {
  std::vector<std::string> names;
  Sides sides;
  if (table.has(column)) sides.of_line = number_groups(table.texts(column), names);
  if (names.size() < 2) {
    std::vector<std::string> labels;
    for (const size_t place : place_of_line) labels.push_back(std::to_string(place));
    names.clear();
    sides.of_line = number_groups(labels, names);
  }
  sides.each_in_turn = names.size() < 4;
  sides.count = sides.each_in_turn ? static_cast<int>(names.size()) : 2;
  if (sides.each_in_turn) return sides;
  const std::vector<char> held = held_out_groups(names);
  for (int& side : sides.of_line) side = held[static_cast<size_t>(side)];
  return sides;
}

// One row a place and side, and one a gross measurement; returns each group's side.
std::vector<int> add_rows(const CsvTable& table, const std::vector<size_t>& place_of_line,
                          const std::vector<double>& measured, const Sides& sides, RangeData& data,
                          Facts& facts) {
  std::vector<std::vector<size_t>> lines_of_place(data.places.size());
  for (size_t line = 0; line < table.rows(); ++line)
    lines_of_place[place_of_line[line]].push_back(line);
  const std::vector<char> far = gross(measured, lines_of_place, data.places);
  std::vector<int> side_of_group;
  const auto add = [&](RangeRow row, int line, int side) {
    const BallPlace& place = data.places[row.place];
    const std::string name =
        fmt::format("side {} at {} m, {} rad{}", side, place.true_m, place.bearing_rad,
                    row.outlier ? fmt::format(", line {}", line) : "");
    facts.group_of_row.push_back(static_cast<int>(facts.groups.size()));
    facts.groups.push_back(name);
    side_of_group.push_back(side);
    facts.line_of_row.push_back(line);
    facts.time_of_row.push_back(static_cast<double>(data.rows.size()));
    facts.series_of_row.push_back(static_cast<int>(row.place));
    for (int channel = 0; channel < (row.count > 1 ? 2 : 1); ++channel) {
      facts.row_of.push_back(static_cast<int>(data.rows.size()));
      facts.channel_of.push_back(channel);
    }
    data.rows.push_back(row);
  };
  for (size_t p = 0; p < data.places.size(); ++p) {
    size_t good = 0;
    for (const size_t line : lines_of_place[p]) good += !far[line];
    for (int side = 0; side < sides.count; ++side) {
      std::vector<double> values;
      int first_line = 0;
      for (const size_t line : lines_of_place[p]) {
        if (far[line] || sides.of_line[line] != side) continue;
        if (values.empty()) first_line = table.line(line);
        values.push_back(measured[line]);
      }
      if (values.empty()) continue;
      add(row_of(p, values, good), first_line, side);
    }
    for (const size_t line : lines_of_place[p]) {
      if (!far[line]) continue;
      RangeRow row = row_of(p, {measured[line]}, 1);
      row.outlier = true;
      add(row, table.line(line), sides.of_line[line]);
    }
  }
  return side_of_group;
}

}  // namespace

std::vector<size_t> read_places(const CsvTable& table, std::vector<BallPlace>& places) {
  if (table.rows() == 0)
    throw InputError(fmt::format("{}: no rows, expected measurements", table.file()));
  const std::vector<double> true_m = table.numbers("true_m");
  const std::vector<double> bearing = table.has("bearing_rad")
                                          ? table.numbers("bearing_rad")
                                          : std::vector<double>(table.rows(), 0);
  const auto before = [](const BallPlace& a, const BallPlace& b) {
    return std::pair(a.true_m, a.bearing_rad) < std::pair(b.true_m, b.bearing_rad);
  };
  std::map<BallPlace, size_t, decltype(before)> known(before);
  for (size_t row = 0; row < table.rows(); ++row) {
    if (!(true_m[row] >= kNearest_m && true_m[row] <= kFarthest_m)) {
      table.fail(row, "true_m", table.cell(row, "true_m"),
                 fmt::format("a distance from {} to {} m", kNearest_m, kFarthest_m));
    }
    if (std::abs(bearing[row]) > maths::kPi) {
      table.fail(row, "bearing_rad", table.cell(row, "bearing_rad"), "an angle from -pi to pi");
    }
    known[{true_m[row], bearing[row]}] = 0;
  }
  for (auto& [place, number] : known) {
    number = places.size();
    places.push_back(place);
  }
  std::vector<size_t> place_of_line;
  for (size_t row = 0; row < table.rows(); ++row)
    place_of_line.push_back(known[{true_m[row], bearing[row]}]);
  return place_of_line;
}

RangeData read_ranges(const MeasurementSet& set, Facts& facts) {
  RangeData data;
  const CsvTable table = set.table("ranges");
  table.texts("trial");  // Must be there, whatever groups are held out.
  const std::vector<size_t> place_of_line = read_places(table, data.places);
  const std::vector<double> measured = table.numbers("measured_m");
  for (size_t row = 0; row < table.rows(); ++row) {
    if (!(measured[row] > 0 && measured[row] < 1e3)) {
      table.fail(row, "measured_m", table.cell(row, "measured_m"),
                 "a distance of more than 0 and less than 1000 m");
    }
  }
  facts.set.kind = effects::kRanges;
  facts.title = set.title;
  facts.fingerprint = set.fingerprint();
  facts.file = table.file();

  const Sides sides = sides_of(table, set.group, place_of_line);
  const std::vector<int> side_of_group =
      add_rows(table, place_of_line, measured, sides, data, facts);
  for (int side = sides.each_in_turn ? 0 : 1; side < sides.count; ++side) {
    Groups fold;
    for (const int s : side_of_group) fold.push_back(s == side);
    if (std::find(fold.begin(), fold.end(), 1) != fold.end()) data.folds.push_back(std::move(fold));
  }

  std::vector<double> range, bearing;
  for (const RangeRow& row : data.rows) {
    range.push_back(data.places[row.place].true_m);
    bearing.push_back(data.places[row.place].bearing_rad);
  }
  facts.covariates.push_back({.name = "range", .values = std::move(range)});
  if (table.has("bearing_rad"))
    facts.covariates.push_back({.name = "bearing", .values = std::move(bearing)});
  return data;
}

}  // namespace seam::measurement
