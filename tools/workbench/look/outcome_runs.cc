#include "tools/workbench/look/outcome_runs.h"

#include "measurement/kinds/outcomes/outcomes.h"
#include "tools/workbench/look/columns.h"

namespace seam::tools {

using nlohmann::json;

std::string predicted_runs(const measurement::Problem& problem, const measurement::Model& model) {
  const auto* outcomes = dynamic_cast<const measurement::OutcomesProblem*>(&problem);
  if (outcomes == nullptr) return "";
  json scenarios = json::array();
  std::vector<float> numbers;
  for (const measurement::RunsOfScenario& one : outcomes->runs(model)) {
    scenarios.push_back(
        {{"name", one.scenario}, {"values", one.values}, {"runs", one.table.front().size()}});
    for (const std::vector<double>& values : one.table)
      numbers.insert(numbers.end(), values.begin(), values.end());
  }
  std::string bytes = head_bytes({{"scenarios", std::move(scenarios)}});
  bytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(float));
  return bytes;
}

}  // namespace seam::tools
