#include "measurement/sets/left_out.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>

#include "measurement/sets/set.h"
#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"

namespace seam::measurement {
namespace {

constexpr const char* kFile = "file";
constexpr const char* kRow = "row";
constexpr const char* kReason = "reason";

[[noreturn]] void refuse(const CsvTable& list, size_t at, const char* column,
                         const std::string& expected) {
  throw UsageError(fmt::format("{}:{}: column {}: found '{}', expected {}", list.file(),
                               list.line(at), column, shown(list.cell(at, column)), expected));
}

CsvTable read_list(const std::filesystem::path& file) {
  try {
    CsvTable list = CsvTable::read(file);
    for (const char* column : {kRow, kReason}) {
      if (!list.has(column))
        throw UsageError(
            fmt::format("{}:1: column '{}' is missing, expected row,reason or "
                        "file,row,reason",
                        list.file(), column));
    }
    for (const std::string& column : list.columns()) {
      if (column != kFile && column != kRow && column != kReason)
        throw UsageError(
            fmt::format("{}:1: found column '{}', expected row,reason or "
                        "file,row,reason",
                        list.file(), shown(column)));
    }
    return list;
  } catch (const InputError& error) {
    throw UsageError(
        fmt::format("{}. Expected rows `row,reason` (no comma in a reason)", error.what()));
  }
}

// The lines of one table of the set that hold a row.
struct KnownLines {
  std::string file;
  std::set<int> lines;
};

KnownLines known_lines(const MeasurementSet& set, const std::string& name) {
  const CsvTable table = CsvTable::read(set.file(name));
  KnownLines known{.file = table.file()};
  for (size_t row = 0; row < table.rows(); ++row) known.lines.insert(table.line(row));
  return known;
}

std::string name_of_table(const CsvTable& list, size_t at, const MeasurementSet& set,
                          const std::string& observations) {
  if (!list.has(kFile) || list.cell(at, kFile).empty()) return observations;
  const std::string name(list.cell(at, kFile));
  if (!set.has_file(name)) {
    std::vector<std::string> names;
    for (const auto& [table, file] : set.files) names.push_back(table);
    refuse(list, at, kFile,
           fmt::format("a name under `files:` of the set: {}", fmt::join(names, ", ")));
  }
  return name;
}

int line_of(const CsvTable& list, size_t at, const KnownLines& known) {
  const std::string_view cell = list.cell(at, kRow);
  int line = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), line);
  const bool is_number = error == std::errc() && end == cell.data() + cell.size();
  if (!is_number || !known.lines.contains(line)) {
    refuse(list, at, kRow,
           known.lines.empty()
               ? fmt::format("a line of {}, which has no rows", known.file)
               : fmt::format("a line of {} with a row, {} to {} (the header is line 1)", known.file,
                             *known.lines.begin(), *known.lines.rbegin()));
  }
  return line;
}

void count_reason(const std::string& reason, std::vector<LeftOutRows>& reasons) {
  const auto same = std::find_if(reasons.begin(), reasons.end(),
                                 [&](const LeftOutRows& rows) { return rows.reason == reason; });
  if (same == reasons.end()) {
    reasons.push_back({.reason = reason, .rows = 1});
  } else {
    ++same->rows;
  }
}

}  // namespace

void LeftOut::take_from(const std::string& name, CsvTable& table) const {
  const auto found = lines.find(name);
  if (found == lines.end()) return;
  std::vector<char> kept(table.rows());
  for (size_t row = 0; row < table.rows(); ++row)
    kept[row] = !found->second.contains(table.line(row));
  table.keep_rows(kept);
}

std::string LeftOut::sentence() const {
  size_t count = 0;
  std::vector<std::string> parts;
  for (const LeftOutRows& rows : reasons) {
    count += rows.rows;
    parts.push_back(fmt::format("{} {}", rows.rows, rows.reason));
  }
  return fmt::format("{} {} left out by choice: {}", count, count == 1 ? "row" : "rows",
                     fmt::join(parts, ", "));
}

LeftOut read_left_out(const std::filesystem::path& file, const MeasurementSet& set,
                      const std::string& observations) {
  const CsvTable list = read_list(file);
  LeftOut out;
  std::map<std::string, KnownLines> known;
  std::map<std::pair<std::string, int>, int> named_in;  // By table and line: the line of the list.
  for (size_t at = 0; at < list.rows(); ++at) {
    const std::string name = name_of_table(list, at, set, observations);
    if (!known.contains(name)) known[name] = known_lines(set, name);
    const int line = line_of(list, at, known[name]);
    const auto [earlier, is_new] = named_in.try_emplace({name, line}, list.line(at));
    if (!is_new)
      refuse(list, at, kRow, fmt::format("each row once: line {} has it already", earlier->second));
    const std::string reason = shown(list.cell(at, kReason));
    if (reason.empty()) refuse(list, at, kReason, "why the row is left out");
    out.lines[name].insert(line);
    count_reason(reason, out.reasons);
  }
  for (const auto& [name, lines] : out.lines) {
    CsvTable rest = set.table(name);
    out.take_from(name, rest);
    if (rest.rows() == 0)
      throw UsageError(fmt::format("{}: leaves out every row of {}, expected some to be left",
                                   list.file(), rest.file()));
  }
  return out;
}

}  // namespace seam::measurement
