#include "app/sweep/table.h"

#include <fmt/format.h>

#include "sim_core/input/shown_text.h"

namespace seam::app {
namespace {

std::string text_of(const std::optional<int>& score) {
  return score ? fmt::format("{}", *score) : "";
}

std::string summary_cell(const RunRecord& record, const std::string& column) {
  const bool ran = !record.fingerprint.empty();
  if (column == "seed") return fmt::format("{}", record.seed);
  if (column == "end") return record.failed() && !ran ? "failed" : record.end;
  const bool is_score = column == "red_score" || column == "blue_score";
  if (is_score && record.failed()) return "";
  if (column == "red_score") return text_of(record.red_score);
  if (column == "blue_score") return text_of(record.blue_score);
  if (!ran || record.failed()) return "";  // Nothing of half a run is averaged by accident.
  if (column == "sim_s") return fmt::format("{}", record.sim_s);
  if (column == "frames") return fmt::format("{}", record.frames);
  if (column == "decisions") return fmt::format("{}", record.decisions);
  return record.fingerprint;
}

// Of several lines the first, so that a run stays a line of the table.
std::string first_line(const std::string& text) {
  return text.substr(0, text.find_first_of("\r\n"));
}

}  // namespace

std::vector<std::string> table_columns(const SweepPlan& plan) {
  std::vector<std::string> columns = {"run"};
  if (plan.repetitions() > 1) columns.emplace_back("repetition");
  for (const std::string& parameter : plan.parameters())
    if (parameter != "seed") columns.push_back(parameter);
  for (const std::string& column : plan.keep().summary) columns.push_back(column);
  for (const std::string& column : plan.keep().columns()) columns.push_back(column);
  columns.emplace_back("error");
  return columns;
}

std::vector<std::string> table_cells(const SweepPlan& plan, const RunRecord& record) {
  const RunSettings settings = plan.settings(record.run);
  std::vector<std::string> cells = {fmt::format("{}", record.run)};
  if (plan.repetitions() > 1) cells.push_back(fmt::format("{}", settings.repetition));
  for (size_t i = 0; i < settings.values.size(); ++i)
    if (plan.parameters()[i] != "seed") cells.push_back(settings.values[i].text);
  for (const std::string& column : plan.keep().summary)
    cells.push_back(summary_cell(record, column));
  const size_t kept = plan.keep().columns().size();
  for (size_t i = 0; i < kept; ++i) {
    const bool there = i < record.kept.size() && !record.failed();
    const auto value = there ? record.kept[i] : std::nullopt;
    cells.push_back(value ? fmt::format("{}", *value) : "");
  }
  cells.push_back(first_line(record.error));
  return cells;
}

std::string csv_line(const std::vector<std::string>& cells) {
  std::string line;
  for (size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) line += ',';
    // Results may be of others' making.
    const std::string cell = shown_lines(cells[i]);
    if (cell.find_first_of(",\"\r\n") == std::string::npos) {
      line += cell;
      continue;
    }
    line += '"';
    for (const char c : cell) {
      if (c == '"') line += '"';
      line += c;
    }
    line += '"';
  }
  return line + '\n';
}

}  // namespace seam::app
