#include "app/import/pictures/picture_times.h"

#include <algorithm>
#include <cctype>
#include <tuple>

#include "app/import/draft/checks.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

// The last number in a name, as its digits: whole, and behind a point.
struct NameNumber {
  std::string whole, part;
};

NameNumber number_in(const std::string& stem) {
  const auto digit = [&](size_t i) {
    return std::isdigit(static_cast<unsigned char>(stem[i])) != 0;
  };
  size_t end = stem.size();
  while (end > 0 && !digit(end - 1)) --end;
  size_t start = end;
  while (start > 0 && digit(start - 1)) --start;
  NameNumber number{stem.substr(start, end - start), ""};
  size_t before = start;
  if (start > 1 && stem[start - 1] == '.' && digit(start - 2)) {
    before = start - 1;
    while (before > 0 && digit(before - 1)) --before;
    number = {stem.substr(before, start - 1 - before), stem.substr(start, end - start)};
  }
  return number;
}

// The unit of stamps by how many digits a time since 1970 has in it; 0 for a plain number.
int64_t stamp_unit_ns(const NameNumber& number) {
  switch (number.whole.size()) {
    case 19:
      return 1;
    case 16:
      return 1'000;
    case 13:
      return 1'000'000;
    case 10:
      return number.part.empty() ? 0 : 1'000'000'000;
    default:
      return 0;
  }
}

}  // namespace

// By the numbers in their names, so that 10 comes behind 9.
void sort_by_number(std::vector<fs::path>& pictures) {
  const auto key = [](const fs::path& path) {
    NameNumber number = number_in(path.stem().string());
    number.whole.erase(0, std::min(number.whole.find_first_not_of('0'), number.whole.size()));
    return std::tuple(number.whole.size(), number.whole, number.part, path.string());
  };
  std::sort(pictures.begin(), pictures.end(),
            [&](const fs::path& a, const fs::path& b) { return key(a) < key(b); });
}

PictureTimes::PictureTimes(std::string how, std::map<std::string, int64_t> stamps_ns)
    : how_(std::move(how)), rows_(std::move(stamps_ns)) {}

PictureTimes::PictureTimes(const std::vector<fs::path>& pictures, const TextTable* table,
                           const ImportRequest& request) {
  if (table != nullptr) {
    read_table(*table, request);
    return;
  }
  int64_t usual_ns = 0;
  unit_ns_ = request.time_unit.empty() ? 0 : nanoseconds_in(request.time_unit);
  for (size_t i = 0; unit_ns_ == 0 && i < pictures.size(); ++i) {
    const int64_t unit = stamp_unit_ns(number_in(pictures[i].stem().string()));
    if (i > 0 && unit != usual_ns) return;
    usual_ns = unit;
  }
  if (unit_ns_ == 0) unit_ns_ = usual_ns;
}

int64_t PictureTimes::of(const fs::path& picture) const {
  int64_t ns = 0;
  if (!rows_.empty()) {
    const auto row = rows_.find(picture.filename().string());
    if (row == rows_.end())
      throw InputError(fmt::format("{}: found no row of {}", how_, picture.string()));
    return row->second;
  }
  const NameNumber number = number_in(picture.stem().string());
  const std::string text = number.part.empty() ? number.whole : number.whole + "." + number.part;
  if (!parse_time_ns(text, unit_ns_, ns))
    throw InputError(fmt::format("{}: its name holds no time", picture.string()));
  return ns;
}

void PictureTimes::read_table(const TextTable& table, const ImportRequest& request) {
  const auto column = [&](const char* quantity, std::vector<std::string> usual) {
    const std::string mapped = request.name_of(quantity);
    if (!mapped.empty()) usual = {mapped};
    return table.find(usual);
  };
  how_ = table.file();
  const int file =
      column("file", {"file", "filename", "image", "name", "path", "#filename", "frame"});
  const int time = column("time", {"time_s", "timestamp", "time", "stamp", "t", "timestamp_ns",
                                   "time_ns", "#timestamp [ns]", "timestamp [ns]", "time_ms"});
  if (file < 0 || time < 0)
    throw InputError(
        fmt::format("{}:1: expected columns file and time; say theirs with --map", table.file()));
  const auto at = static_cast<size_t>(time);
  int64_t unit = time_unit_ns(request, table.full_name(at));
  if (request.time_unit.empty() && table.column_name(at).find("[ns]") != std::string::npos)
    unit = 1;
  for (size_t row = 0; row < table.rows(); ++row) {
    const fs::path name(std::string(table.cell(row, static_cast<size_t>(file))));
    rows_[name.filename().string()] = table.time_ns(row, at, unit);
  }
}

}  // namespace seam::app
