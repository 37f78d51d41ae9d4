#include "app/sweep/plan/keep.h"

#include <algorithm>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

// What of a summary is a number.
constexpr const char* kSummaryNumbers[] = {"seed",      "sim_s",     "frames",
                                           "decisions", "red_score", "blue_score"};

bool is_name(const std::string& text) {
  const auto letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  };
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  return !text.empty() && letter(text.front()) &&
         std::all_of(text.begin(), text.end(), [&](char c) { return letter(c) || digit(c); });
}

std::string robot_of(const ConfigNode& value, const Scenario& scenario) {
  std::vector<std::string> ids;
  for (const RobotSpec& robot : scenario.robots) ids.push_back(robot.id);
  const auto given = value.is_map() ? value.find("robot") : std::nullopt;
  if (given) return ids.at(given->choice(ids));
  if (ids.size() != 1)
    value.fail(
        fmt::format("the scenario has {} robots: say whose value, as in "
                    "{{name: x_m, robot: {}}}",
                    ids.size(), ids.empty() ? "ID" : ids.front()));
  return ids.front();
}

KeptValue read_value(const ConfigNode& node, const Scenario& scenario) {
  KeptValue value;
  value.robot = robot_of(node, scenario);
  value.where = node.where();
  if (node.is_scalar()) {
    value.name = value.column = node.text();
    return value;
  }
  value.name = node.at("name").text();
  const std::vector<std::string> statistics(kStatisticNames.begin(), kStatisticNames.end());
  if (const auto statistic = node.find("statistic"))
    value.statistic = static_cast<Statistic>(statistic->choice(statistics));
  const std::string prefix =
      value.statistic == Statistic::last
          ? ""
          : std::string(kStatisticNames.at(static_cast<size_t>(value.statistic))) + "_";
  value.column = node.text_or("as", prefix + value.name);
  value.optional = node.boolean_or("optional", false);
  node.finish();
  return value;
}

// A formula reads what has a name that can stand in one.
KeptFormula read_formula(const std::string& column, const ConfigNode& node,
                         const std::vector<std::string>& known) {
  std::vector<std::string> names;
  std::copy_if(known.begin(), known.end(), std::back_inserter(names), is_name);
  try {
    const std::string text = node.text();
    std::vector<std::string> reads = effects::Formula::names_in(text);
    for (const std::string& name : reads) {
      if (std::find(names.begin(), names.end(), name) == names.end())
        node.fail(fmt::format("unknown name '{}'{}", name, suggestion_for(name, names)));
    }
    return {column, effects::Formula(text, reads), reads};
  } catch (const InputError& error) {
    if (std::string_view(error.what()).starts_with(node.file())) throw;
    node.fail(error.what());
  }
}

}  // namespace

std::vector<std::string> Keep::columns() const {
  std::vector<std::string> names;
  for (const KeptValue& value : values) names.push_back(value.column);
  for (const KeptFormula& formula : formulas) names.push_back(formula.column);
  return names;
}

Keep read_keep(const std::optional<ConfigNode>& node, const Scenario& scenario,
               const std::vector<std::string>& parameters,
               const std::set<std::string>& without_number) {
  Keep keep;
  const std::vector<std::string> summary(kSummaryColumns.begin(), kSummaryColumns.end());
  keep.summary = summary;
  if (!node) return keep;
  if (const auto wanted = node->find("summary")) {
    keep.summary.clear();
    for (const ConfigNode& item : wanted->items())
      keep.summary.push_back(summary.at(item.choice(summary)));
  }
  if (const auto values = node->find("values"))
    for (const ConfigNode& item : values->items())
      keep.values.push_back(read_value(item, scenario));
  std::vector<std::string> known = parameters;
  known.insert(known.end(), std::begin(kSummaryNumbers), std::end(kSummaryNumbers));
  for (const KeptValue& value : keep.values) known.push_back(value.column);
  if (const auto formulas = node->find("expressions")) {
    for (const std::string& column : formulas->keys()) {
      const ConfigNode formula = formulas->at(column);
      keep.formulas.push_back(read_formula(column, formula, known));
      for (const std::string& name : keep.formulas.back().reads) {
        if (without_number.contains(name))
          formula.fail(fmt::format("reads '{}', which is a number in no run of the plan", name));
        if (name.ends_with("_score") && !scenario.referee.enabled &&
            std::find(parameters.begin(), parameters.end(), name) == parameters.end())
          formula.fail(fmt::format("reads '{}', but the scenario has no referee", name));
      }
      known.push_back(column);
    }
  }
  keep.logs = node->boolean_or("logs", false);
  keep.frames = node->boolean_or("frames", false);
  node->finish();
  return keep;
}

}  // namespace seam::app
