#include "measurement/kinds/outcomes/outcomes_data.h"

#include <algorithm>
#include <cmath>

#include "effects/registry.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

constexpr const char* kReadingColumn = "reading_sigma";

std::map<std::string, Bounds> read_bounds(const effects::EffectDefinition& effect,
                                          const ConfigNode& node) {
  std::map<std::string, Bounds> bounds;
  for (const effects::Parameter& parameter : effect.parameters) {
    const auto given = node.find(parameter.name);
    if (!given) continue;
    const std::vector<double> ends = given->numbers(2);
    if (!(ends[0] < ends[1])) given->fail("expected [low, high] with low < high");
    bounds[parameter.name] = {std::max(ends[0], parameter.min), std::min(ends[1], parameter.max)};
  }
  node.finish();
  return bounds;
}

size_t place_of(const std::string& name, const std::vector<std::string>& known,
                const CsvTable& table, size_t row, const char* column) {
  const auto found = std::find(known.begin(), known.end(), name);
  if (found == known.end()) {
    table.fail(row, column, name, "a name of the set" + suggestion_for(name, known));
  }
  return static_cast<size_t>(found - known.begin());
}

Covariate category(const std::string& name, const std::vector<std::string>& labels) {
  std::vector<std::string> names;
  const std::vector<int> numbers = number_groups(labels, names);
  return {.name = name,
          .type = Covariate::Type::category,
          .values = {numbers.begin(), numbers.end()},
          .in_products = false};
}

}  // namespace

OutcomeSettings read_settings(const MeasurementSet& set) {
  OutcomeSettings settings;
  const ConfigNode scenarios = set.root.at("scenarios");
  for (const std::string& name : scenarios.keys())
    settings.runs.plans.push_back({name, set.inside(scenarios.at(name))});
  if (settings.runs.plans.empty())
    scenarios.fail("found none, expected names with a plan of runs (seam-sweep/1) each");
  if (const auto robots = set.root.find("robots")) {
    for (const ConfigNode& robot : robots->items()) settings.runs.robots.push_back(robot.text());
  }
  settings.most_runs =
      static_cast<uint64_t>(set.root.integer_or("most_runs", kUsualMostRuns, 1, kMostRuns));
  if (const auto candidates = set.root.find("candidates")) {
    settings.candidates.emplace();
    for (const std::string& name : candidates->keys()) {
      const auto effect = effects::find_effect(name);
      if (!effect) {
        candidates->fail(fmt::format("unknown effect '{}'{}", name,
                                     suggestion_for(name, effects::effect_names())));
      }
      const auto bounds = candidates->find(name);  // None: the record's own.
      settings.candidates->emplace(
          name, bounds ? read_bounds(*effect, *bounds) : std::map<std::string, Bounds>());
    }
  }
  return settings;
}

std::vector<OutcomeRow> read_outcomes(const CsvTable& table, const RunSpec& spec,
                                      const RunMaker& runs, Measured measured) {
  const bool made = measured == Measured::to_be_made;
  const std::vector<std::string> scenario = table.texts("scenario"), value = table.texts("value"),
                                 statistic = table.texts("statistic");
  std::vector<double> numbers, sigmas;
  if (!made) numbers = table.numbers("measured"), sigmas = table.numbers("sigma");
  std::vector<double> readings(table.rows(), 0);
  if (table.has(kReadingColumn)) readings = table.numbers_or_blank(kReadingColumn);
  std::vector<std::string> plans;
  for (const RunPlan& plan : spec.plans) plans.push_back(plan.name);
  std::vector<OutcomeRow> rows;
  for (size_t row = 0; row < table.rows(); ++row) {
    OutcomeRow out;
    out.plan = place_of(scenario[row], plans, table, row, "scenario");
    out.statistic.column = place_of(value[row], runs.columns(out.plan), table, row, "value");
    try {
      out.statistic.statistic = RunStatistic::named(statistic[row]);
    } catch (const InputError& error) {
      table.fail(row, "statistic", statistic[row], error.what());
    }
    if (std::isfinite(readings[row])) out.reading = readings[row];
    if (out.reading < 0)
      table.fail(row, kReadingColumn, table.cell(row, kReadingColumn), "an error of 0 or more");
    if (!made) {
      out.measured = numbers[row], out.sigma = sigmas[row];
      if (!(out.sigma > 0))
        table.fail(row, "sigma", table.cell(row, "sigma"), "an error of more than 0");
    }
    rows.push_back(std::move(out));
  }
  if (rows.empty())
    throw InputError(fmt::format("{}: no rows, expected measured statistics", table.file()));
  return rows;
}

void describe_outcomes(const MeasurementSet& set, const CsvTable& table,
                       const std::vector<OutcomeRow>& rows, Facts& facts) {
  facts.set.kind = effects::kOutcomes;
  facts.title = set.title;
  facts.fingerprint = set.fingerprint();
  facts.file = table.file();
  facts.tests_neighbours = false;
  const std::vector<std::string> values = table.texts("value");
  facts.group_of_row = number_groups(table.texts(set.group), facts.groups);
  // A channel is one statistic of one value: of scenarios that all have it.
  std::vector<std::string> channels;
  std::vector<double> square, count;
  for (size_t row = 0; row < rows.size(); ++row) {
    const std::string name =
        fmt::format("{} {}", rows[row].statistic.statistic.name(), values[row]);
    const auto found = std::find(channels.begin(), channels.end(), name);
    const auto channel = static_cast<size_t>(found - channels.begin());
    if (found == channels.end()) channels.push_back(name), square.push_back(0), count.push_back(0);
    square[channel] += rows[row].sigma * rows[row].sigma, ++count[channel];
    facts.line_of_row.push_back(table.line(row));
    facts.time_of_row.push_back(static_cast<double>(row));
    facts.row_of.push_back(static_cast<int>(row));
    facts.channel_of.push_back(static_cast<int>(channel));
  }
  for (size_t c = 0; c < channels.size(); ++c)
    facts.channels.push_back({.name = channels[c], .noise = std::sqrt(square[c] / count[c])});
  facts.covariates.push_back(category("scenario", table.texts("scenario")));
  facts.covariates.push_back(category("value", values));
  facts.covariates.push_back(category("statistic", table.texts("statistic")));
}

}  // namespace seam::measurement
