#include "measurement/check/faults.h"

#include <algorithm>

#include "measurement/check/fault_parts.h"
#include "sim_core/base/error.h"

namespace seam::measurement {

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

std::vector<std::string> faults_of_values(const MeasurementSet& set) {
  std::vector<std::string> found;
  try {
    if (set.kind == "joints") joint_faults(set, found);
    if (set.kind == "odometry") walk_faults(set, found);
    if (set.kind == "landmarks") landmark_faults(set, found);
    if (set.kind == "points") point_faults(set, found);
    if (set.kind == "ranges") range_faults(set, found);
    if (set.kind == "photometry" || set.kind == "frames") picture_faults(set, found);
  } catch (const InputError&) {
    // What cannot be read is told where it is read to be used.
  }
  return found;
}

}  // namespace seam::measurement
