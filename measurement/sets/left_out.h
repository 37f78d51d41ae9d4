// Rows that a person leaves out of a set, each with a reason: a table `row,reason`, with a column
// `file` where other tables than the observations are meant (docs/reference/measurements.md, "Rows
// left out").
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "measurement/sets/csv.h"

namespace seam::measurement {

struct MeasurementSet;

struct LeftOutRows {
  std::string reason;
  size_t rows = 0;
};

struct LeftOut {
  std::map<std::string, std::set<int>> lines;  // By table, its name under `files:`.
  std::vector<LeftOutRows> reasons;            // As they first occur in the file.

  bool empty() const { return lines.empty(); }
  void take_from(const std::string& name, CsvTable& table) const;
  // "3 rows left out by choice: 2 blurred, 1 wrong corner".
  std::string sentence() const;
};

// The rows of `set` that a file leaves out; where it names no table, of `observations`. Throws
// UsageError with file and line for rows that the set lacks, rows named twice, and where no row of
// a table is left.
LeftOut read_left_out(const std::filesystem::path& file, const MeasurementSet& set,
                      const std::string& observations);

}  // namespace seam::measurement
