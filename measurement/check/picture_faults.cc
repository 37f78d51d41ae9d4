// Faults of sets of pictures: files that are the same to the last byte.
#include <fmt/format.h>

#include "measurement/check/fault_parts.h"
#include "sim_core/base/files.h"

namespace seam::measurement {

void picture_faults(const MeasurementSet& set, std::vector<std::string>& found) {
  const CsvTable table = set.table("frames");
  if (!table.has("file")) return;
  std::string before;
  size_t repeated = 0, first = 0;
  for (size_t row = 0; row < table.rows(); ++row) {
    const auto path = set.inside(table, row, "file");
    if (!std::filesystem::is_regular_file(path)) return;
    std::string bytes = read_file(path);
    // Noise makes no picture twice.
    if (row > 0 && bytes == before && repeated++ == 0) first = row;
    before = std::move(bytes);
  }
  if (repeated > 0)
    found.push_back(
        fmt::format("{}: {} pictures are those before them to the last byte: frames "
                    "that were stored twice",
                    place(table, first), repeated));
}

}  // namespace seam::measurement
