#include "measurement/sets/observations.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace seam::measurement {
namespace {

// No instrument measures more in any of the units used here.
constexpr double kLargestValue = 1e9;
// Detectors that fit a mark may put its middle a little outside the image; farther is another
// camera.
constexpr double kMarginShare = 0.1;

std::string place(const CsvTable& table, size_t row, const std::string& column) {
  return fmt::format("{}:{}: column {}", table.file(), table.line(row), column);
}

std::vector<std::string> present(const CsvTable& table, const std::vector<std::string>& columns) {
  std::vector<std::string> found;
  for (const std::string& column : columns) {
    if (table.has(column)) found.push_back(column);
  }
  return found;
}

// Rows by what stands in the columns; NUL cannot stand in a cell that is read as a number.
std::string row_text(const CsvTable& table, size_t row, const std::vector<std::string>& columns) {
  std::string text;
  for (const std::string& column : columns) {
    text += table.cell(row, column);
    text += '\0';
  }
  return text;
}

void find_rows_twice(const CsvTable& table, const ObservationTable& observations,
                     const std::string& group, Concerns& concerns) {
  std::vector<std::string> keys = present(table, observations.keys);
  const std::vector<std::string> measured = present(table, observations.measured);
  if (keys.empty()) return;
  if (table.has(group) && std::find(keys.begin(), keys.end(), group) == keys.end())
    keys.push_back(group);
  std::unordered_map<std::string, std::vector<size_t>> rows_of_key;  // Only looked up.
  std::string first_twice, first_anew;
  for (size_t row = 0; row < table.rows(); ++row) {
    std::vector<size_t>& earlier = rows_of_key[row_text(table, row, keys)];
    const auto same = std::find_if(earlier.begin(), earlier.end(), [&](size_t other) {
      return row_text(table, other, measured) == row_text(table, row, measured);
    });
    if (same != earlier.end()) {
      if (concerns.rows_twice++ == 0)
        first_twice = fmt::format("{}:{}: found the row of line {} again (same {})", table.file(),
                                  table.line(row), table.line(*same), fmt::join(keys, ", "));
    } else {
      if (!earlier.empty() && concerns.measured_anew++ == 0)
        first_anew = fmt::format("{}:{}: measures the {} of line {} anew", table.file(),
                                 table.line(row), fmt::join(keys, ", "), table.line(earlier[0]));
      earlier.push_back(row);
    }
  }
  if (concerns.rows_twice > 0)
    concerns.errors.push_back(fmt::format(
        "{}, expected each observation once: {} of {} rows stand twice, which makes the noise look "
        "smaller than it is",
        first_twice, concerns.rows_twice, table.rows()));
  if (concerns.measured_anew > 0)
    concerns.warnings.push_back(
        fmt::format("{}; {} of {} rows do so", first_anew, concerns.measured_anew, table.rows()));
}

void find_absurd_values(const CsvTable& table, const std::string& column, Concerns& concerns) {
  const std::vector<double> values = table.numbers_or_blank(column);
  const auto absurd = [](double value) { return std::abs(value) > kLargestValue; };
  const auto first = std::find_if(values.begin(), values.end(), absurd);
  if (first == values.end()) return;
  const auto row = static_cast<size_t>(first - values.begin());
  const auto count = std::count_if(first, values.end(), absurd);
  concerns.errors.push_back(fmt::format("{}: found '{}', expected a magnitude of at most {:g}{}",
                                        place(table, row, column), table.cell(row, column),
                                        kLargestValue,
                                        count > 1 ? fmt::format(" (and {} more)", count - 1) : ""));
}

// One coordinate against the image's size along it.
struct Side {
  std::string column;
  std::vector<double> values;
  int size_px = 0;

  // By how many pixels a value lies outside.
  double outside(double value, int of_px) const {
    return std::max({0.0, -0.5 - value, value - (of_px - 0.5)});
  }
};

void find_places_outside(const CsvTable& table, const MeasurementSet& set,
                         const ObservationTable& observations, Concerns& concerns) {
  const Side sides[2] = {
      {observations.measured[0], table.numbers(observations.measured[0]), set.camera.width_px},
      {observations.measured[1], table.numbers(observations.measured[1]), set.camera.height_px}};
  size_t far = 0, outside_exchanged = 0;
  std::string first_near, first_far;
  for (size_t row = 0; row < table.rows(); ++row) {
    bool is_outside = false, is_far = false, would_be = false;
    for (int axis = 0; axis < 2; ++axis) {
      const Side& side = sides[axis];
      const double by = side.outside(side.values[row], side.size_px);
      would_be = would_be || side.outside(side.values[row], sides[1 - axis].size_px) > 0;
      if (by == 0) continue;
      is_outside = true;
      const bool beyond = by > kMarginShare * side.size_px;
      std::string& first = beyond ? first_far : first_near;
      if (first.empty())
        first = fmt::format("{}: found '{}', expected a place in the image of {} x {} pixels",
                            place(table, row, side.column), table.cell(row, side.column),
                            set.camera.width_px, set.camera.height_px);
      is_far = is_far || beyond;
    }
    concerns.outside_image += is_outside;
    far += is_far;
    outside_exchanged += would_be;
  }
  if (concerns.outside_image == 0) return;
  std::string counted =
      fmt::format("; {} of {} points lie outside it", concerns.outside_image, table.rows());
  if (outside_exchanged == 0)
    counted += fmt::format(". {0} and {1} exchanged? With {1} for {0} all lie inside",
                           sides[0].column, sides[1].column);
  (far > 0 ? concerns.errors : concerns.warnings)
      .push_back((far > 0 ? first_far : first_near) + counted);
}

}  // namespace

bool is_protocol(const MeasurementSet& set, const ObservationTable& observations) {
  return !observations.measured.empty() &&
         present(set.table(observations.file), observations.measured).empty();
}

Concerns concerns_of(const MeasurementSet& set, const ObservationTable& observations) {
  Concerns concerns;
  if (observations.file.empty() || !set.has_file(observations.file)) return concerns;
  const CsvTable table = set.table(observations.file);
  const std::vector<std::string> measured = present(table, observations.measured);
  // A protocol has no measured columns yet; its rows may well be asked for twice.
  if (measured.empty() && !observations.measured.empty()) return concerns;
  if (observations.in_image && measured.size() >= 2 && set.camera.width_px > 0) {
    find_places_outside(table, set, observations, concerns);
  } else {
    for (const std::string& column : measured) find_absurd_values(table, column, concerns);
  }
  find_rows_twice(table, observations, set.group, concerns);
  return concerns;
}

}  // namespace seam::measurement
