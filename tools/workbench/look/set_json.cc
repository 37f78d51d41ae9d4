#include "tools/workbench/look/set_json.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "measurement/check/describe.h"
#include "measurement/report/finite_or_null.h"
#include "sim_core/base/error.h"

namespace seam::tools {
namespace {

using measurement::CsvTable;
using measurement::finite_or_null;
using measurement::unit_of;
using nlohmann::json;

json column_json(const CsvTable& table, const std::string& file, const std::string& name) {
  json column = {{"name", name}, {"unit", unit_of(name)}, {"file", file}};
  const std::vector<std::string> texts = table.texts(name);
  column["missing"] = std::count(texts.begin(), texts.end(), "");
  try {
    double low = INFINITY, high = -INFINITY;
    for (const double value : table.numbers_or_blank(name)) {
      if (std::isnan(value)) continue;
      low = std::min(low, value), high = std::max(high, value);
    }
    column["low"] = finite_or_null<json>(low), column["high"] = finite_or_null<json>(high);
  } catch (const InputError&) {  // A column of names.
    column["low"] = column["high"] = nullptr;
  }
  return column;
}

json columns_json(const measurement::MeasurementSet& set) {
  json columns = json::array();
  for (const auto& [name, file] : set.files) {
    if (!file.ends_with(".csv")) continue;
    const CsvTable table = set.table(name);
    for (const std::string& column : table.columns())
      columns.push_back(column_json(table, file, column));
  }
  return columns;
}

// A sentence, with the row that it names as "file:LINE:".
json doubt_json(const measurement::Facts& facts, const std::string& text) {
  json doubt = {{"text", text}};
  const std::string name = std::filesystem::path(facts.file).filename().string() + ":";
  const size_t at = text.find(name);
  if (at == std::string::npos) return doubt;
  int line = 0;
  std::from_chars(text.data() + at + name.size(), text.data() + text.size(), line);
  const auto found = std::find(facts.line_of_row.begin(), facts.line_of_row.end(), line);
  if (found == facts.line_of_row.end()) return doubt;
  const auto row = found - facts.line_of_row.begin();
  doubt["rows"] = {{row, row}};
  return doubt;
}

// What an import wrote down of the set; a set that says it in another way was made by hand.
std::vector<std::string> import_said(const measurement::MeasurementSet& set, const char* what) {
  std::vector<std::string> sentences;
  try {
    const auto imported = set.root.find("imported");
    const auto list = imported ? imported->find(what) : std::nullopt;
    if (!list) return {};
    for (const ConfigNode& sentence : list->items()) sentences.push_back(sentence.text());
  } catch (const InputError&) {
    return {};
  }
  return sentences;
}

}  // namespace

json set_json(const measurement::Problem& problem, const AnalysisFlags& flags,
              const measurement::Doubts& doubts) {
  const measurement::Facts& facts = problem.facts();
  const auto set = measurement::MeasurementSet::open(flags.data);
  json noise = json::object();
  bool estimated = false;
  for (const measurement::Channel& channel : facts.channels) {
    noise[channel.name] = finite_or_null<json>(channel.noise);
    estimated = estimated || channel.estimated;
  }
  json fields = json::array();
  const auto described = measurement::describe_set(set, std::nullopt);
  const std::vector<std::string> of_import = import_said(set, "doubts");
  for (const auto* list : {&of_import, &doubts, &described.errors, &described.warnings}) {
    for (const std::string& text : *list) fields.push_back(doubt_json(facts, text));
  }
  json set_json = {
      {"title", facts.title},
      {"kind", facts.kind()},
      {"file", std::filesystem::path(facts.file).filename().string()},
      {"rows", facts.rows()},
      {"groups", facts.groups.size()},
      {"group", set.group},
      {"noise", std::move(noise)},
      {"noise_estimated", estimated},
      {"columns", columns_json(set)},
      {"doubts", std::move(fields)},
      {"imported",
       {{"done", import_said(set, "done")}, {"not_known", import_said(set, "not_known")}}}};
  if (facts.width_px > 0)
    set_json["image"] = {{"width_px", facts.width_px}, {"height_px", facts.height_px}};
  return set_json;
}

}  // namespace seam::tools
