#include "app/import/files/signals.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/import/files/cell_lists.h"
#include "app/import/files/source_file.h"
#include "app/import/files/text_table.h"
#include "sim_core/base/error.h"
#include "sim_core/input/json_input.h"

namespace seam::app {
namespace {

using nlohmann::json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr size_t kMaxSignals = 1000;

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// A name without what people write in their own way: blanks for underscores, a unit at the end.
std::string plain(std::string text) {
  text = lower(std::move(text));
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == ' ' || c == '-' || c == '/'; }, '_');
  for (const char* unit : {"_deg", "_rad", "_degrees", "_radians", "_s", "_sec", "_seconds"}) {
    if (text.ends_with(unit)) return text.substr(0, text.size() - std::string_view(unit).size());
  }
  return text;
}

int place_among(const std::vector<std::string>& names, const std::vector<std::string>& wanted) {
  for (const bool as_it_stands : {true, false}) {
    for (const std::string& given : wanted) {
      const std::string name = as_it_stands ? lower(given) : plain(given);
      const auto is_it = [&](const std::string& other) {
        if (as_it_stands) return other.size() == name.size() && lower(other) == name;
        return other.size() >= name.size() && plain(other) == name;
      };
      const auto found = std::find_if(names.begin(), names.end(), is_it);
      if (found != names.end()) return static_cast<int>(found - names.begin());
    }
  }
  return -1;
}

bool is_list_of(const json& value, bool (json::*is)() const noexcept) {
  return value.is_array() && !value.empty() &&
         std::all_of(value.begin(), value.end(), [&](const json& item) { return (item.*is)(); });
}
bool is_list_of_objects(const json& value) {
  return is_list_of(value, &json::is_object);
}
bool is_list_of_numbers(const json& value) {
  return value.is_array() && !value.empty() &&
         std::all_of(value.begin(), value.end(),
                     [](const json& item) { return item.is_number() || item.is_boolean(); });
}
bool is_table_of_numbers(const json& value) {
  return value.is_array() && !value.empty() &&
         std::all_of(value.begin(), value.end(), is_list_of_numbers);
}

void note_odd(SignalLog& log, const std::string& name, const std::string& text, size_t row) {
  const bool blank = text.empty() || text == "-" || lower(text) == "nan";
  if (!blank && row < log.rows()) log.odd.try_emplace(name, log.places[row], text);
}

// Reads one JSON value into a log.
class JsonSignals {
 public:
  JsonSignals(SignalLog& log, const json& root) : log_(log) {
    const json* rows = rows_in(root, "");
    if (rows != nullptr) {
      for (size_t i = 0; i < rows->size(); ++i) add_row((*rows)[i], i);
      log_.constants.erase("");
    } else {
      add_columns(root, "");
    }
    for (auto& column : log_.values) column.resize(log_.rows(), kNone);
  }

 private:
  // The first list of objects, from the outside inwards; numbers beside it are constants.
  const json* rows_in(const json& value, const std::string& name) {
    if (is_list_of_objects(value)) {
      list_ = name;
      return &value;
    }
    if (!value.is_object()) return nullptr;
    for (const auto& [key, child] : value.items()) {
      if (child.is_number()) log_.constants[key] = child.get<double>();
      if (child.is_boolean()) log_.constants[key] = child.get<bool>() ? 1 : 0;
    }
    for (const auto& [key, child] : value.items()) {
      if (const json* rows = rows_in(child, name.empty() ? key : name + "." + key)) return rows;
    }
    return nullptr;
  }

  std::vector<double>& column(const std::string& name) {
    const auto [found, is_new] = place_.try_emplace(name, log_.names.size());
    if (is_new) {
      if (log_.names.size() >= kMaxSignals)
        throw InputError(fmt::format("{}: more than {} signals", log_.file, kMaxSignals));
      log_.names.push_back(name);
      log_.full_names.push_back(name);
      log_.values.emplace_back();
    }
    return log_.values[found->second];
  }

  void set(const std::string& name, size_t row, const json& value) {
    if (value.is_object()) {
      for (const auto& [key, child] : value.items()) set(name + "." + key, row, child);
    } else if (value.is_array()) {
      for (size_t i = 0; i < value.size(); ++i) set(fmt::format("{}[{}]", name, i), row, value[i]);
    } else if (int64_t ns = 0; value.is_string() && parse_date_ns(value.get<std::string>(), ns)) {
      set(name, row, 1e-9 * static_cast<double>(ns));
    } else if (value.is_string()) {
      auto& words = log_.texts[name];
      words.resize(row + 1);
      words[row] = value.get<std::string>();
      note_odd(log_, name, words[row], row);
    } else {
      std::vector<double>& values = column(name);
      values.resize(row, kNone);
      values.push_back(value.is_number()    ? value.get<double>()
                       : value.is_boolean() ? (value.get<bool>() ? 1.0 : 0.0)
                                            : kNone);
    }
  }

  void add_row(const json& row, size_t number) {
    log_.places.push_back(fmt::format("{}: {}[{}]", log_.file, list_, number));
    for (const auto& [key, value] : row.items()) set(key, number, value);
  }

  void add_list(const std::string& name, const json& list, const std::string& within) {
    if (log_.places.empty()) {
      for (size_t i = 0; i < list.size(); ++i)
        log_.places.push_back(fmt::format("{}: row {}", log_.file, i));
    }
    if (list.size() != log_.places.size())
      throw InputError(fmt::format("{}: {}{}: found {} values, expected {} as in the lists before",
                                   log_.file, within, name, list.size(), log_.places.size()));
    for (size_t i = 0; i < list.size(); ++i) set(name, i, list[i]);
  }

  void add_columns(const json& value, const std::string& within) {
    if (!value.is_object()) return;
    const json* mapping = value.contains("signal_mapping") ? &value["signal_mapping"] : nullptr;
    for (const auto& [key, child] : value.items()) {
      if (&child == mapping) continue;
      if (mapping != nullptr && is_table_of_numbers(child)) {
        add_mapped(*mapping, child);
      } else if (is_list_of_numbers(child) || is_table_of_numbers(child)) {
        add_list(key, child, within);
      } else if (is_list_of(child, &json::is_string)) {
        log_.lists[key] = child.get<std::vector<std::string>>();
      } else if (child.is_object()) {
        add_columns(child, within + key + ".");
      } else if (child.is_number()) {
        log_.constants[key] = child.get<double>();
      }
    }
  }

  // A matrix with the names of its columns beside it: {NAME: [TYPE, [COLUMN, ...]]}.
  void add_mapped(const json& mapping, const json& table) {
    if (!mapping.is_object()) return add_list("data", table, "");
    for (const auto& [name, entry] : mapping.items()) {
      const json& columns = entry.is_array() && !entry.empty() ? entry.back() : entry;
      if (!is_list_of_numbers(columns)) continue;
      for (size_t c = 0; c < columns.size(); ++c) {
        const double at = columns[c].is_number() ? columns[c].get<double>() : -1;
        const std::string full = columns.size() == 1 ? name : fmt::format("{}[{}]", name, c);
        json list = json::array();
        for (const json& row : table) {
          if (!(at >= 0 && at < static_cast<double>(row.size())))
            throw InputError(
                fmt::format("{}: signal_mapping: {}: found column {}, expected one of "
                            "{}",
                            log_.file, name, at, row.size()));
          list.push_back(row[static_cast<size_t>(at)]);
        }
        add_list(full, list, "");
      }
    }
  }

  SignalLog& log_;
  std::string list_;
  std::map<std::string, size_t> place_;
};

// A list of the objects that stand on a line each (JSON Lines); null where they do not.
json json_of_lines(const std::string& text, const std::string& name) {
  json list = json::array();
  for (size_t start = text.find('{'); start < text.size();) {
    const size_t end = std::min(text.find('\n', start), text.size());
    std::string line = text.substr(start, end - start);
    const size_t last = line.find_last_not_of(" \t\r");
    line.resize(last == std::string::npos ? 0 : last + 1);
    start = end + 1;
    if (line.empty()) continue;
    if (line.front() != '{' || line.back() != '}' || (list.empty() && end + 1 >= text.size()))
      return nullptr;
    list.push_back(
        json_from_text(line, fmt::format("{}: entry {}", name, list.size()), "an object"));
  }
  return list.size() > 1 ? list : json(nullptr);
}

void add_column(SignalLog& log, const TextTable& table, size_t c) {
  std::vector<double> values;
  std::vector<int64_t> ns;
  std::vector<std::string> words;
  size_t numbers = 0;
  for (size_t row = 0; row < table.rows(); ++row) {
    double value = kNone;
    int64_t exact = 0;
    const std::string text_of_cell = lower(std::string(table.cell(row, c)));
    if (text_of_cell == "true" || text_of_cell == "false") value = text_of_cell == "true" ? 1 : 0;
    const bool timed = parse_time_ns(table.cell(row, c), 1'000'000'000, exact);
    if (!parse_number(text_of_cell, value) && std::isnan(value) && timed)
      value = 1e-9 * static_cast<double>(exact);
    if (std::isnan(value)) note_odd(log, table.columns()[c], std::string(table.cell(row, c)), row);
    numbers += std::isnan(value) ? 0 : 1;
    values.push_back(value), ns.push_back(exact);
    words.emplace_back(table.cell(row, c));
  }
  const std::string& name = table.columns()[c];
  if (numbers * 2 < table.rows()) log.texts[name] = std::move(words);
  if (numbers == 0) return;
  log.names.push_back(name);
  log.full_names.push_back(table.full_name(c));
  log.values.push_back(std::move(values));
  log.exact_ns.push_back(std::move(ns));
}

// A column whose cells are lists of `count` items: NAME[0], NAME[1], ... where they are numbers;
// else words by row and item, as texts NAME[0], ...
void add_lists(SignalLog& log, const TextTable& table, size_t c, size_t count) {
  if (count > kMaxSignals || log.names.size() + count > kMaxSignals)
    throw InputError(fmt::format("{}: more than {} signals", log.file, kMaxSignals));
  std::vector<std::vector<double>> values(count);
  std::vector<std::vector<std::string>> words(count);
  std::vector<std::string_view> items;
  bool numeric = true;
  for (size_t row = 0; row < table.rows(); ++row) {
    const bool blank = table.cell(row, c).empty();
    if (!blank && (!list_in(table.cell(row, c), items) || items.size() != count))
      table.fail(row, c, fmt::format("a list of {} items as in the rows above", count));
    for (size_t i = 0; i < count; ++i) {
      double value = kNone;
      const std::string item = blank ? "" : std::string(items[i]);
      numeric = (parse_number(item, value) || blank || lower(item) == "nan") && numeric;
      values[i].push_back(value), words[i].push_back(item);
      if (std::isnan(value)) note_odd(log, fmt::format("{}[{}]", table.columns()[c], i), item, row);
    }
  }
  for (size_t i = 0; i < count; ++i) {
    const std::string name = fmt::format("{}[{}]", table.columns()[c], i);
    if (!numeric) {
      log.texts[name] = std::move(words[i]);
      continue;
    }
    log.names.push_back(name);
    log.full_names.push_back(fmt::format("{}[{}]", table.full_name(c), i));
    log.values.push_back(std::move(values[i]));
    log.exact_ns.emplace_back(table.rows(), 0);
  }
}

// Lists of names, whose order may change from row to row: the numbers beside them in that of the
// first row, and the names once.
void order_by_names(SignalLog& log) {
  for (const auto& [first, in_first] : std::map(log.texts)) {
    if (!first.ends_with("[0]")) continue;
    const std::string base = first.substr(0, first.size() - 3);
    std::vector<const std::vector<std::string>*> names;
    for (size_t i = 0; log.texts.contains(fmt::format("{}[{}]", base, i)); ++i)
      names.push_back(&log.texts.at(fmt::format("{}[{}]", base, i)));
    const auto is_short = [&](const auto* words) { return words->size() != log.rows(); };
    if (std::any_of(names.begin(), names.end(), is_short)) continue;
    std::vector<std::string>& list = log.lists[base];
    std::map<std::string, size_t> place;
    for (const auto* of_item : names) {
      place.emplace(of_item->front(), list.size());
      list.push_back(of_item->front());
    }
    // Of each list of numbers that is as long, its signals.
    std::vector<std::vector<size_t>> lists;
    for (size_t c = 0; c < log.names.size(); ++c) {
      const size_t bracket = log.names[c].find("[0]");
      if (bracket == std::string::npos) continue;
      const std::string of = log.names[c].substr(0, bracket);
      std::vector<size_t> signals;
      for (int at = 0; (at = log.find({fmt::format("{}[{}]", of, signals.size())})) >= 0;)
        signals.push_back(static_cast<size_t>(at));
      if (signals.size() == names.size()) lists.push_back(signals);
    }
    for (size_t row = 1; row < log.rows(); ++row) {
      std::vector<size_t> to;
      for (const auto* of_item : names) {
        const auto found = place.find((*of_item)[row]);
        if (found == place.end())
          throw InputError(
              fmt::format("{}: {}: found the joint '{}', expected those of the first row",
                          log.places[row], base, (*of_item)[row]));
        to.push_back(found->second);
      }
      for (const std::vector<size_t>& signals : lists) {
        std::vector<double> before;
        for (const size_t signal : signals) before.push_back(log.values[signal][row]);
        for (size_t i = 0; i < to.size(); ++i) log.values[signals[to[i]]][row] = before[i];
      }
    }
  }
}

void read_table(SignalLog& log, std::string text) {
  const TextTable table = TextTable::from_text(std::move(text), log.file);
  if (table.columns().empty())
    throw InputError(fmt::format("{}:{}: found no names of columns, expected a header", log.file,
                                 table.line(0)));
  for (size_t c = 0; c < table.columns().size(); ++c) {
    const std::vector<std::string>& all = table.columns();
    if (std::find(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(c), all[c]) !=
        all.begin() + static_cast<std::ptrdiff_t>(c))
      throw InputError(fmt::format("{}: column '{}' stands twice", log.file, all[c]));
  }
  for (size_t row = 0; row < table.rows(); ++row)
    log.places.push_back(fmt::format("{}:{}", log.file, table.line(row)));
  for (size_t c = 0; c < table.width(); ++c) {
    std::vector<std::string_view> items;
    size_t first = 0;
    while (first + 1 < table.rows() && table.cell(first, c).empty()) ++first;
    if (table.rows() > 0 && list_in(table.cell(first, c), items)) {
      add_lists(log, table, c, items.size());
    } else {
      add_column(log, table, c);
    }
  }
}

}  // namespace

int SignalLog::find(const std::vector<std::string>& wanted) const {
  return place_among(names, wanted);
}

std::string SignalLog::find_words(const std::vector<std::string>& wanted) const {
  std::vector<std::string> words;
  for (const auto& [name, cells] : texts) words.push_back(name);
  const int at = place_among(words, wanted);
  return at < 0 ? "" : words[static_cast<size_t>(at)];
}

SignalLog signals_of_text(std::string text, const std::string& name) {
  SignalLog log{.file = name};
  if (text.starts_with("PAR1"))
    throw InputError(
        fmt::format("{0}: found a Parquet file, which is not read, expected CSV, JSON or NPZ: "
                    "convert it, python3 "
                    "-c \"import pandas; pandas.read_parquet('{0}').to_json('episodes.jsonl', "
                    "orient='records', lines=True)\"",
                    name));
  if (text.starts_with("PK\x03\x04")) {
    read_npz_signals(log, text);
    return log;
  }
  const size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first != std::string::npos && (text[first] == '{' || text[first] == '[')) {
    const json root = json_of_lines(text, name);
    JsonSignals(log, root.is_null() ? json_from_text(text, name, "a log of signals") : root);
    if (log.rows() == 0 || log.names.empty())
      throw InputError(fmt::format(
          "{}: found no list of samples, expected a list of objects or equally long lists", name));
  } else {
    read_table(log, std::move(text));
  }
  order_by_names(log);
  return log;
}

SignalLog read_signals(const std::filesystem::path& path) {
  return signals_of_text(read_source(path), path.string());
}

}  // namespace seam::app
