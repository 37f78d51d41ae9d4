#include "measurement/plan/changes.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <string_view>

#include "effects/kind.h"
#include "measurement/kinds/kinds.h"
#include "measurement/sets/rig.h"

namespace seam::measurement {
namespace {

constexpr double kFaster = 2, kWider = 1.5;
constexpr const char* kTable = ".csv";

// Whether time is that of a motion which may be made faster: a head's, a servo's, a robot's.
bool moves(const MeasurementSet& set) {
  if (set.kind == "joints" || set.kind == "landmarks") return true;
  const auto rig = set.root.find("rig");
  const auto poses = rig && rig->is_map() ? rig->find("poses") : std::nullopt;
  return set.kind == "points" && (set.has_file("joints") || (poses && set.has_file(poses->text())));
}

// The first time in any table of the set, so that all of them are shortened alike.
double first_time_s(const MeasurementSet& set) {
  double first = std::numeric_limits<double>::infinity();
  for (const auto& [name, file] : set.files) {
    if (!file.ends_with(kTable)) continue;
    const CsvTable table = set.table(name);
    if (!table.has("time_s")) continue;
    for (const double time_s : table.numbers("time_s")) first = std::min(first, time_s);
  }
  return first;
}

// Times since the first, since an epoch's would need more digits than a table is written with.
std::vector<double> faster(const CsvTable& table, double first_s, double factor) {
  std::vector<double> values = table.numbers("time_s");
  for (double& value : values) value = (value - first_s) / factor;
  return values;
}

// By joint: commands farther from their mean.
std::vector<double> wider(const CsvTable& table, double factor) {
  std::vector<double> values = table.numbers("command_rad");
  std::map<std::string_view, std::pair<double, double>> sum;  // And count, by joint.
  const auto joint = [&](size_t row) {
    return table.has("joint") ? table.cell(row, "joint") : std::string_view();
  };
  for (size_t row = 0; row < values.size(); ++row) {
    auto& [total, count] = sum[joint(row)];
    total += values[row], ++count;
  }
  for (size_t row = 0; row < values.size(); ++row) {
    const auto& [total, count] = sum[joint(row)];
    values[row] = total / count + factor * (values[row] - total / count);
  }
  return values;
}

// Rows with names of their own for each repetition, after each other in time.
void write_repeated(const CsvTable& table, const std::string& group, int repeats,
                    const std::filesystem::path& path) {
  const std::vector<double> times_s = table.numbers("time_s");
  const double rows = static_cast<double>(std::max<size_t>(2, times_s.size()));
  const auto [first, last] = std::minmax_element(times_s.begin(), times_s.end());
  const double period_s = (*last - *first) * rows / (rows - 1);
  CsvWriter writer(table.columns());
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (size_t row = 0; row < table.rows(); ++row) {
      std::vector<std::string> cells;
      for (const std::string& column : table.columns()) {
        std::string& cell = cells.emplace_back(table.cell(row, column));
        if (column == "time_s") cell = fmt::format("{:.9f}", times_s[row] + repeat * period_s);
        if (repeat == 0) continue;
        if (column == group) cell += fmt::format("-{}", repeat + 1);
        if (column == "file")
          cell.insert(std::min(cell.rfind('.'), cell.size()), fmt::format("-{}", repeat + 1));
      }
      writer.row(cells);
    }
  }
  writer.write(path);
}

}  // namespace

bool needs_its_measurements(const MeasurementSet& protocol) {
  return protocol.kind == "points" && !protocol.has_file("poses") &&
         Rig::from_set(protocol).type() == Rig::Type::unknown;
}

std::vector<ProtocolChange> changes_of(const MeasurementSet& protocol) {
  std::vector<ProtocolChange> changes = {
      {.what = fmt::format("twice as many {}s", protocol.group), .cost = 2, .repeats = 2},
      {.what = fmt::format("four times as many {}s", protocol.group), .cost = 4, .repeats = 4}};
  if (moves(protocol))
    changes.push_back({.what = "the same motion twice as fast", .faster = kFaster});
  if (protocol.kind == "joints")
    changes.push_back({.what = "commands 1.5 times as wide", .wider = kWider});
  return changes;
}

void write_changed(const MeasurementSet& protocol, const ProtocolChange& change,
                   const std::filesystem::path& folder) {
  copy_protocol(protocol, folder, {});
  const MeasurementSet copy = MeasurementSet::open(folder);
  const double first_s = first_time_s(copy);
  for (const auto& [name, file] : copy.files) {
    if (!file.ends_with(kTable)) continue;
    const CsvTable table = copy.table(name);
    if (change.repeats != 1 && table.has("file"))
      write_repeated(table, copy.group, static_cast<int>(change.repeats), copy.file(name));
    if (change.faster != 1 && table.has("time_s"))
      write_table_with(table, {"time_s"}, {faster(table, first_s, change.faster)}, copy.file(name));
    if (change.wider != 1 && table.has("command_rad"))
      write_table_with(table, {"command_rad"}, {wider(table, change.wider)}, copy.file(name));
  }
}

}  // namespace seam::measurement
