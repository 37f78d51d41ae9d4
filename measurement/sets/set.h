// A measurement set's folder: `measurement.yaml` (seam-measurement/1) and the files that it names.
// What every kind shares; the kinds read their own tables.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "measurement/sets/csv.h"
#include "measurement/sets/left_out.h"
#include "sim_core/base/config.h"

namespace seam::measurement {

// Of sets of outcomes: runs that one command may make, where the set says nothing and at most.
inline constexpr int64_t kUsualMostRuns = 20'000, kMostRuns = 1'000'000;

struct CameraFacts {
  int width_px = 0;  // 0 where the set names no camera.
  int height_px = 0;
  double frame_period_s = 0;
  std::string channels = "grey";  // grey | rgb
  int bits = 8;
};

struct MeasurementSet {
  std::filesystem::path folder;
  std::string kind;
  std::string title;
  CameraFacts camera;
  std::map<std::string, double> noise;  // One sigma by column; empty where unknown.
  std::string group;                    // The column whose groups are held out whole.
  std::map<std::string, std::string> files;
  // Two columns of its tables that are read as each other, to see whether they were mixed up; empty
  // as the set stands.
  std::pair<std::string, std::string> exchanged;
  // Of this table (its name under `files:`) the first rows of each group alone, by time_s.
  struct Beginning {
    std::string table;
    size_t rows = 0;  // 0: all.
  };
  Beginning beginning;
  LeftOut left_out;  // Rows of its tables that take no part, and why.
  // A table of where the points of the target were found earlier (point, x_m, y_m, z_m), which goes
  // before the set's own; empty: none.
  std::filesystem::path target;
  ConfigNode root;  // For what a kind reads itself: rig, scene, detector.

  // `path` is the folder or its measurement.yaml. Throws InputError.
  static MeasurementSet open(const std::filesystem::path& path);

  // JSON Schema of measurement.yaml (docs/reference/schemas/measurement.schema.json), from the
  // table that `open` reads.
  static std::string schema();

  // The full path of a named file; throws when `files:` does not name it.
  std::filesystem::path file(const std::string& name) const;
  // The full path of a file of the set that a key of measurement.yaml or a cell of a table names;
  // throws where that is no path inside the folder, naming the place of the name.
  std::filesystem::path inside(const ConfigNode& name) const;
  std::filesystem::path inside(const CsvTable& table, size_t row, std::string_view column) const;
  bool has_file(const std::string& name) const { return files.contains(name); }
  CsvTable table(const std::string& name) const;

  // One sigma of a column; 0 where the set states none.
  double noise_of(const std::string& column) const;

  // Of measurement.yaml, the files it names and the rows left out, as 16 hexadecimal digits.
  std::string fingerprint() const;
};

// Which groups are held out: the ceil(0.3 G) with the smallest hash of (group id, fixed seed).
std::vector<char> held_out_groups(const std::vector<std::string>& group_ids);

// Numbers text values in order of first appearance; `names` gets each new one.
std::vector<int> number_groups(const std::vector<std::string>& values,
                               std::vector<std::string>& names);

}  // namespace seam::measurement
