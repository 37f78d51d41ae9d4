#include "app/sweep/plan/axis.h"

#include <yaml-cpp/yaml.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <memory>

#include "measurement/sets/csv.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"
#include "sim_core/base/random.h"

namespace seam::app {
namespace {

constexpr int64_t kMostDraws = 1'000'000'000'000;
constexpr double kAnything = std::numeric_limits<double>::max();

WrittenValue number_of(double value) {
  return {fmt::format("{}", value)};
}
WrittenValue number_of(int64_t value) {
  return {fmt::format("{}", value)};
}

bool is_whole(const ConfigNode& node) {
  const std::string text = node.text();
  int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

SweepParameter read_parameter(const ConfigNode& entry) {
  SweepParameter parameter;
  const ConfigNode path = entry.at("path");
  if (path.is_scalar()) {
    parameter.paths.push_back(path.text());
  } else {
    for (const ConfigNode& item : path.items()) parameter.paths.push_back(item.text());
    if (parameter.paths.empty()) path.fail("expected at least one path");
  }
  parameter.name = entry.text_or("name", parameter.paths.front());
  return parameter;
}

Axis read_values(const ConfigNode& entry, const ConfigNode& values) {
  Axis axis{.parameters = {read_parameter(entry)}};
  std::vector<WrittenValue> all;
  for (const ConfigNode& item : values.items()) all.push_back(written(item));
  if (all.empty()) values.fail("expected at least one value");
  axis.size = all.size();
  axis.value = [all](size_t, uint64_t i) { return all.at(i); };
  return axis;
}

// Whole numbers where first, last and step are whole; the last one is part of it where it is met.
Axis read_range(const ConfigNode& entry, const ConfigNode& range) {
  Axis axis{.parameters = {read_parameter(entry)}};
  const auto ends = range.items();
  if (ends.size() != 2) range.fail("expected [first, last]");
  const auto step = entry.find("step");
  if (is_whole(ends[0]) && is_whole(ends[1]) && (!step || is_whole(*step))) {
    const int64_t limit = int64_t{1} << 60;
    const int64_t first = ends[0].integer(-limit, limit), last = ends[1].integer(first, limit);
    const int64_t by = step ? step->integer(1, limit) : 1;
    axis.size = static_cast<uint64_t>((last - first) / by) + 1;
    axis.value = [first, by](size_t, uint64_t i) {
      return number_of(first + static_cast<int64_t>(i) * by);
    };
    return axis;
  }
  const double first = ends[0].number(), last = ends[1].number({first, kAnything});
  const double by = step ? step->number({1e-300, kAnything}) : 1;
  // The last one is met also where the steps add up to it but for rounding.
  const double steps = std::floor((last - first) / by + 1e-9);
  if (steps >= 1e18) range.fail(fmt::format("found {} steps, expected fewer", steps));
  axis.size = static_cast<uint64_t>(steps) + 1;
  axis.value = [first, by](size_t, uint64_t i) {
    return number_of(first + static_cast<double>(i) * by);
  };
  return axis;
}

// A distribution of one parameter, drawn by counter.
using Draw = std::function<WrittenValue(RandomStream stream, uint64_t index)>;

Draw read_draw(const ConfigNode& entry) {
  if (const auto ends = entry.find("uniform")) {
    const auto numbers = ends->numbers(2);
    if (numbers[1] < numbers[0]) ends->fail("expected [least, greatest]");
    return [low = numbers[0], width = numbers[1] - numbers[0]](RandomStream s, uint64_t i) {
      return number_of(low + width * uniform(s, i));
    };
  }
  if (const auto ends = entry.find("log_uniform")) {
    const auto numbers = ends->numbers(2);
    if (numbers[0] <= 0 || numbers[1] < numbers[0])
      ends->fail("expected [least, greatest], both greater than 0");
    const double low = maths::log(numbers[0]), width = maths::log(numbers[1]) - low;
    return [low, width](RandomStream s, uint64_t i) {
      return number_of(maths::exp(low + width * uniform(s, i)));
    };
  }
  if (const auto moments = entry.find("normal")) {
    const auto numbers = moments->numbers(2);
    if (numbers[1] < 0) moments->fail("expected [mean, sigma], sigma not below 0");
    return [mean = numbers[0], sigma = numbers[1]](RandomStream s, uint64_t i) {
      return number_of(mean + sigma * normal(s, i));
    };
  }
  if (const auto ends = entry.find("integer")) {
    const auto items = ends->items();
    if (items.size() != 2) ends->fail("expected [least, greatest]");
    const int64_t limit = int64_t{1} << 52;
    const int64_t low = items[0].integer(-limit, limit), high = items[1].integer(low, limit);
    return [low, count = static_cast<double>(high - low + 1)](RandomStream s, uint64_t i) {
      return number_of(low + static_cast<int64_t>(std::floor(count * uniform(s, i))));
    };
  }
  entry.finish();  // A misspelt key is an error that names the nearest one.
  entry.fail("expected a distribution: uniform, log_uniform, normal or integer");
}

// Each parameter has a stream of its own, named by its path: one more beside it changes none.
Axis read_draws(const ConfigNode& entry, const ConfigNode& draws) {
  Axis axis;
  axis.size = static_cast<uint64_t>(draws.integer(1, kMostDraws));
  const int64_t seed = entry.integer_or("seed", 1, 0, std::numeric_limits<int64_t>::max());
  const RandomStream root = RandomStream{static_cast<uint64_t>(seed)}.child("sweep");
  std::vector<std::pair<RandomStream, Draw>> all;
  const auto add = [&](const ConfigNode& node) {
    axis.parameters.push_back(read_parameter(node));
    all.emplace_back(root.child(axis.parameters.back().paths.front()), read_draw(node));
  };
  if (const auto several = entry.find("of")) {
    for (const ConfigNode& item : several->items()) {
      add(item);
      item.finish();
    }
    if (all.empty()) several->fail("expected at least one parameter");
  } else {
    add(entry);
  }
  axis.value = [all](size_t parameter, uint64_t i) {
    return all.at(parameter).second(all.at(parameter).first, i);
  };
  return axis;
}

Axis read_table(const ConfigNode& entry, const ConfigNode& name, PlanFiles& files) {
  Axis axis;
  std::string text;
  try {
    text = files.text(name.text());
  } catch (const InputError& error) {
    name.fail(error.what());
  }
  const auto table = measurement::CsvTable::from_text(std::move(text), name.text());
  if (table.rows() == 0) name.fail("the table has no row");
  const auto renamed = entry.find("columns");
  std::vector<std::vector<std::string>> columns;
  for (const std::string& column : table.columns()) {
    const auto paths = renamed ? renamed->find(column) : std::nullopt;
    axis.parameters.push_back({column, {paths ? paths->text() : column}});
    columns.push_back(table.texts(column));
  }
  if (renamed) renamed->finish();
  axis.size = table.rows();
  axis.value = [columns](size_t parameter, uint64_t i) {
    return WrittenValue{columns.at(parameter).at(i)};
  };
  return axis;
}

}  // namespace

WrittenValue written(const ConfigNode& value) {
  if (value.is_scalar()) return {value.text()};
  YAML::Emitter out;
  out.SetMapFormat(YAML::Flow);
  out.SetSeqFormat(YAML::Flow);
  out << value.yaml();
  return {out.c_str(), false};
}

Axis read_axis(const ConfigNode& entry, PlanFiles& files) {
  const std::vector<const char*> kinds = {"values", "range", "draws", "table"};
  std::string kind;
  for (const char* name : kinds) {
    if (!entry.has(name)) continue;
    if (!kind.empty()) entry.fail(fmt::format("found both '{}' and '{}'", kind, name));
    kind = name;
  }
  Axis axis;
  if (kind == "values") {
    axis = read_values(entry, entry.at(kind));
  } else if (kind == "range") {
    axis = read_range(entry, entry.at(kind));
  } else if (kind == "draws") {
    axis = read_draws(entry, entry.at(kind));
  } else if (kind == "table") {
    axis = read_table(entry, entry.at(kind), files);
  } else {
    entry.has("path");
    entry.finish();  // A misspelt key is an error that names the nearest one.
    entry.fail("expected 'values', 'range', 'draws' or 'table'");
  }
  entry.finish();
  return axis;
}

Axis seed_axis(const ConfigNode& seeds) {
  const auto ends = seeds.items();
  if (ends.size() != 2) seeds.fail("expected [first, last]");
  const int64_t limit = int64_t{1} << 60;
  const int64_t first = ends[0].integer(0, limit), last = ends[1].integer(first, limit);
  return {
      .parameters = {{"seed", {"seed"}}},
      .size = static_cast<uint64_t>(last - first) + 1,
      .value = [first](size_t, uint64_t i) { return number_of(first + static_cast<int64_t>(i)); }};
}

}  // namespace seam::app
