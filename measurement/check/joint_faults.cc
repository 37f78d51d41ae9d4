// Faults of servo logs: units of angles, commands that are no commands.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "measurement/check/fault_parts.h"
#include "measurement/check/faults.h"

namespace seam::measurement {
namespace {

// Rows at which an angle goes on a whole turn away, between rows that move by far less: it is
// stated within one turn.
std::vector<size_t> jumps_by_a_turn(const Numbers& angle) {
  constexpr double kTurn_rad = 2 * std::numbers::pi, kLittle_rad = 0.6;
  std::vector<size_t> jumps;
  for (size_t i = 1; i < angle.size(); ++i) {
    const double step = angle[i] - angle[i - 1];
    if (std::abs(std::abs(step) - kTurn_rad) > kLittle_rad) continue;
    const double before = i > 1 ? angle[i - 1] - angle[i - 2] : 0;
    const double after = i + 1 < angle.size() ? angle[i + 1] - angle[i] : 0;
    const auto moves_on = [&](double other) {
      return std::abs(std::remainder(other, kTurn_rad)) < kLittle_rad;
    };
    if (moves_on(before) && moves_on(after)) jumps.push_back(i);
  }
  return jumps;
}

// Well above degrees; an encoder of 10 bits a turn has 163 in a radian.
constexpr double kLeastTicks = 100;

bool are_whole(const Numbers& values) {
  return std::all_of(values.begin(), values.end(),
                     [](double value) { return value == std::floor(value); });
}

// The lines of rows in ascending order: "6, 9-18, 33".
std::string lines_text(const CsvTable& table, const Rows& rows) {
  constexpr size_t kMostParts = 8;
  std::vector<std::string> parts;
  for (size_t i = 0; i < rows.size();) {
    size_t last = i;
    while (last + 1 < rows.size() && rows[last + 1] == rows[last] + 1) ++last;
    if (parts.size() == kMostParts) {
      parts.push_back("...");
      break;
    }
    parts.push_back(last == i ? fmt::format("{}", table.line(rows[i]))
                              : fmt::format("{}-{}", table.line(rows[i]), table.line(rows[last])));
    i = last + 1;
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

void tell_rows_without_drive(const CsvTable& table, Rows rows, std::vector<std::string>& found) {
  // One or two such rows are a glitch of the log.
  constexpr size_t kFewest = 3;
  if (rows.size() < kFewest) return;
  std::sort(rows.begin(), rows.end());
  found.push_back(fmt::format(
      "{}: command_rad is 0 in {} rows while the joint stays away from 0 (lines {}): was the drive "
      "off there? Mark such rows with torque_enable 0 (seam import servo: --off-where command=0)",
      table.file(), rows.size(), lines_text(table, rows)));
}

// `command_span` and `angle_span` are those of the run that spans most.
void tell_units(const CsvTable& table, const Numbers& commands, const Numbers& angles,
                double command_span, double angle_span, std::vector<std::string>& found) {
  // Both alike: no ratio decides, but no joint of a robot turns so far.
  constexpr double kMost_rad = 20;
  if (command_span > kMost_rad && angle_span > kMost_rad)
    found.push_back(fmt::format(
        "{}: command_rad and measured_rad span {:.4g} and {:.4g}, {:.0f} turns: degrees for "
        "radians?",
        table.file(), command_span, angle_span, angle_span / (2 * std::numbers::pi)));
  if (command_span == 0 || angle_span == 0) return;
  const auto tell_unit = [&](double ratio, const char* column, const Numbers& values) {
    if (ratio > kLeastTicks && are_whole(values))
      found.push_back(fmt::format(
          "{}: {} spans {:.0f} times as much as the other angle, in whole numbers: ticks of an "
          "encoder for radians",
          place(table, 0), column, ratio));
    if (const auto unit = unit_of_ratio(ratio, kDegrees, "degrees", "radians"); !unit.empty())
      found.push_back(fmt::format("{}: {} spans {:.0f} times as much as the other angle: {}",
                                  table.file(), column, ratio, unit));
  };
  tell_unit(angle_span / command_span, "measured_rad", angles);
  tell_unit(command_span / angle_span, "command_rad", commands);
}

}  // namespace

void joint_faults(const MeasurementSet& set, std::vector<std::string>& found) {
  const CsvTable table = set.table("joints");
  if (!has_all(table, {"command_rad", "measured_rad"})) return;
  const Numbers commands = table.numbers_or_blank("command_rad");
  const Numbers angles = table.numbers_or_blank("measured_rad");
  const Numbers enabled =
      table.has("torque_enable") ? table.numbers_or_blank("torque_enable") : Numbers();
  size_t equal = 0, moved = 0, wraps = 0;
  Rows without_drive;
  std::string wraps_at;
  std::map<std::string, std::pair<size_t, std::string>> said;  // By sentence: how often, where.
  double command_span = 0, angle_span = 0;
  for (const auto& [name, rows] : rows_by(table, {"run", "joint"})) {
    Numbers command = at(commands, rows), angle = at(angles, rows);
    const auto blank = [](double value) { return std::isnan(value); };
    if (std::any_of(command.begin(), command.end(), blank) ||
        std::any_of(angle.begin(), angle.end(), blank))
      continue;
    for (const size_t i : jumps_by_a_turn(angle)) {
      if (wraps++ == 0) wraps_at = place(table, rows[i]);
    }
    for (size_t i = 1; i < rows.size(); ++i) {
      if (angle[i] == angle[i - 1]) continue;
      ++moved;
      equal += command[i] == angle[i] ? 1 : 0;
    }
    command_span = std::max(command_span, span_of(command));
    angle_span = std::max(angle_span, span_of(angle));
    std::vector<char> acts(rows.size(), 1);
    for (size_t i = 0; i < rows.size() && !enabled.empty(); ++i) acts[i] = enabled[rows[i]] != 0;
    for (const size_t i : rows_without_drive(command, angle, acts)) {
      without_drive.push_back(rows[i]);
      acts[i] = 0;
    }
    const std::string joint(table.has("joint") ? table.cell(rows[0], "joint") : "");
    for (const std::string& sentence : faults_of_command(command, angle, acts, joint)) {
      auto& [count, where] = said[sentence];
      if (count++ == 0) where = fmt::format("{} ({})", place(table, rows[0]), name);
    }
  }
  if (moved >= 20 && equal * 10 > moved * 9)
    found.push_back(fmt::format(
        "{}: command_rad and measured_rad are equal in {} of {} rows in which the joint moves: the "
        "command column is really the measurement",
        table.file(), equal, moved));
  if (wraps > 0)
    found.push_back(fmt::format(
        "{}: measured_rad jumps by a whole turn in this row{}: it is stated within one turn, "
        "expected angles that go on (and commands with them)",
        wraps_at, wraps > 1 ? fmt::format(" and {} others", wraps - 1) : ""));
  tell_rows_without_drive(table, without_drive, found);
  for (const auto& [sentence, where] : said)
    found.push_back(fmt::format("{}: {}{}", where.second, sentence,
                                where.first > 1 ? fmt::format(" ({} runs)", where.first) : ""));
  tell_units(table, commands, angles, command_span, angle_span, found);
}

}  // namespace seam::measurement
