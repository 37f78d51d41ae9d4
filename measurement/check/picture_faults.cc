// Faults of sets of pictures: files that are the same to the last byte.
#include <fmt/format.h>

#include <algorithm>

#include "measurement/check/fault_parts.h"
#include "measurement/imaging/image_file.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam::measurement {
namespace {

// Clipped whole, as at the end of a series of exposures. Files that are no pictures are told as
// such where they are read.
bool has_one_value(const std::string& bytes, const std::string& name) {
  try {
    const Image image = decode_image(bytes, name);
    return std::all_of(image.samples.begin(), image.samples.end(),
                       [&](uint16_t value) { return value == image.samples.front(); });
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

void picture_faults(const MeasurementSet& set, std::vector<std::string>& found) {
  const CsvTable table = set.table("frames");
  if (!table.has("file")) return;
  std::string before;
  size_t repeated = 0, first = 0;
  for (size_t row = 0; row < table.rows(); ++row) {
    const auto path = set.inside(table, row, "file");
    if (!std::filesystem::is_regular_file(path)) return;
    std::string bytes = read_file(path);
    // Noise makes no picture twice, but for one beyond the ends of its range.
    if (row > 0 && bytes == before && !has_one_value(bytes, path.string()) && repeated++ == 0)
      first = row;
    before = std::move(bytes);
  }
  if (repeated > 0)
    found.push_back(
        fmt::format("{}: {} pictures are those before them to the last byte: frames "
                    "that were stored twice",
                    place(table, first), repeated));
}

}  // namespace seam::measurement
