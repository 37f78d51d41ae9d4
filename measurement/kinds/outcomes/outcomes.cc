#include "measurement/kinds/outcomes/outcomes.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <set>

#include "effects/questions.h"
#include "effects/registry.h"
#include "measurement/kinds/missed_channel.h"
#include "measurement/kinds/outcomes/scatter_of_runs.h"
#include "measurement/numerics/linear_algebra.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

bool any_in(const std::vector<size_t>& rows, const Facts& facts, const Groups& groups) {
  return std::any_of(rows.begin(), rows.end(),
                     [&](size_t row) { return groups[facts.group_of_row[row]] != 0; });
}

// Numbers that were measured in the same runs vary together as those of simulated runs do, as far
// as runs scatter by what was measured: the rest of an error (a tape's) is each number's own. What
// few runs say of that is taken the less, the more numbers there are.
Eigen::MatrixXd covariance_of_measured(const ScenarioPrediction& prediction,
                                       const std::vector<double>& sigma) {
  const Eigen::MatrixXd& own = prediction.scatter;
  const Eigen::Index count = own.rows();
  const double trust = static_cast<double>(prediction.told_by) /
                       static_cast<double>(prediction.told_by + sigma.size());
  const auto share = [&](Eigen::Index i) {
    return std::min(1.0, std::sqrt(own(i, i)) / sigma[static_cast<size_t>(i)]);
  };
  Eigen::MatrixXd out(count, count);
  for (Eigen::Index a = 0; a < count; ++a) {
    for (Eigen::Index b = 0; b < count; ++b) {
      const double scale = std::sqrt(own(a, a) * own(b, b));
      const double shared = share(a) * share(b);
      const double correlation = a == b ? 1 : scale > 0 ? trust * shared * own(a, b) / scale : 0;
      out(a, b) = correlation * sigma[static_cast<size_t>(a)] * sigma[static_cast<size_t>(b)];
    }
  }
  return out;
}

bool tells_scatter(const std::vector<OutcomeRow>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const OutcomeRow& row) {
    const std::string& name = row.statistic.statistic.name();
    return name != "mean" && name != "median";
  });
}

}  // namespace

std::unique_ptr<RunMaker> open_runs(const MeasurementSet& set, const OutcomeSettings& settings,
                                    const Instruments& instruments) {
  if (!instruments.runs) {
    throw InputError(fmt::format(
        "{}: sets of kind outcomes need the simulator, which this program does not have",
        set.root.file()));
  }
  return instruments.runs(settings.runs);
}

OutcomesProblem::OutcomesProblem(const MeasurementSet& set, const Instruments& instruments)
    : settings_(read_settings(set)), runs_(open_runs(set, settings_, instruments)) {
  const CsvTable table = set.table("outcomes");
  rows_ = read_outcomes(table, settings_.runs, *runs_, Measured::needed);
  describe_outcomes(set, table, rows_, facts_);
  predictor_ = std::make_unique<OutcomePredictor>(settings_, *runs_, rows_);
}

void OutcomesProblem::place(const Model& given) {
  for (size_t plan = 0; plan < settings_.runs.plans.size(); ++plan) {
    const std::vector<size_t>& rows = predictor_->rows_of_plan()[plan];
    if (rows.empty()) continue;
    const RunPlan& named = settings_.runs.plans[plan];
    const bool learnt = predictor_->learn_scatter(plan, given);
    const auto prediction = learnt ? predictor_->predict(plan, given) : nullptr;
    if (!prediction) {
      throw InputError(fmt::format(
          "{}: its {} runs are more than most_runs: {} in the set allows", named.file.string(),
          runs_->runs(plan) * (1 + further_tables(settings_.runs, *runs_, plan)),
          settings_.most_runs));
    }
    for (size_t i = 0; i < rows.size(); ++i) {
      if (std::isfinite(prediction->statistics.value[i])) continue;
      throw InputError(fmt::format(
          "{}:{}: with model '{}' fewer than half of the runs of {} give this value{}{}",
          facts_.file, facts_.line_of_row[rows[i]], given.name(), named.file.string(),
          prediction->first_error.empty() ? "" : ": ", prediction->first_error));
    }
  }
}

bool OutcomesProblem::predict(const Model& model, const Groups& groups,
                              std::vector<double>& values) const {
  values.assign(rows_.size(), 0);
  for (size_t plan = 0; plan < predictor_->rows_of_plan().size(); ++plan) {
    const std::vector<size_t>& rows = predictor_->rows_of_plan()[plan];
    if (!any_in(rows, facts_, groups)) continue;
    const auto prediction = predictor_->predict(plan, model);
    if (!prediction) return false;
    for (size_t i = 0; i < rows.size(); ++i) {
      values[rows[i]] = prediction->statistics.value[i];
      if (!std::isfinite(values[rows[i]]) && groups[facts_.group_of_row[rows[i]]]) return false;
    }
  }
  return true;
}

std::vector<OutcomesProblem::Block> OutcomesProblem::blocks_of(const Model& model,
                                                               const Groups& groups) const {
  std::vector<Block> blocks;
  for (size_t plan = 0; plan < predictor_->rows_of_plan().size(); ++plan) {
    const std::vector<size_t>& rows = predictor_->rows_of_plan()[plan];
    if (!any_in(rows, facts_, groups)) continue;
    const auto prediction = predictor_->predict(plan, model);
    if (!prediction) return {};
    std::vector<double> sigma;
    for (const size_t row : rows) sigma.push_back(rows_[row].sigma);
    const Eigen::MatrixXd covariance =
        prediction->statistics.covariance + covariance_of_measured(*prediction, sigma);
    for (int group = 0; group < static_cast<int>(facts_.groups.size()); ++group) {
      if (!groups[group]) continue;
      Block block{.group = group};
      std::vector<Eigen::Index> places;
      for (size_t i = 0; i < rows.size(); ++i) {
        if (facts_.group_of_row[rows[i]] != group || left_out(rows[i])) continue;
        block.rows.push_back(rows[i]), places.push_back(static_cast<Eigen::Index>(i));
      }
      if (places.empty()) continue;
      block.root = lower_root(covariance(places, places));
      blocks.push_back(std::move(block));
    }
  }
  return blocks;
}

Evaluation OutcomesProblem::evaluate(const Model& model, const Groups& groups,
                                     const Evaluation*) const {
  Evaluation out;
  out.used.assign(rows_.size(), 0);
  out.whitened.assign(rows_.size(), 0);
  out.sigma.assign(rows_.size(), 1);
  out.log_det.assign(facts_.groups.size(), 0);
  out.residual.assign(rows_.size(), 0);
  std::vector<double> values;
  out.valid = predict(model, groups, values);
  if (!out.valid) return out;
  for (const Block& block : blocks_of(model, groups)) {
    const auto count = static_cast<Eigen::Index>(block.rows.size());
    Eigen::VectorXd residual(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const size_t row = block.rows[static_cast<size_t>(i)];
      residual[i] = out.residual[row] = rows_[row].measured - values[row];
    }
    const Eigen::VectorXd white = block.root.triangularView<Eigen::Lower>().solve(residual);
    for (Eigen::Index i = 0; i < count; ++i) {
      const size_t row = block.rows[static_cast<size_t>(i)];
      out.used[row] = 1;
      out.whitened[row] = white[i];
      out.sigma[row] = block.root.row(i).norm();
      out.log_det[block.group] += 2 * std::log(block.root(i, i));
    }
  }
  return out;
}

std::vector<double> OutcomesProblem::whitened_by(const Model& model, const Groups& groups,
                                                 const std::vector<double>& rows) const {
  std::vector<double> out(rows_.size(), 0);
  for (const Block& block : blocks_of(model, groups)) {
    const auto count = static_cast<Eigen::Index>(block.rows.size());
    Eigen::VectorXd column(count);
    for (Eigen::Index i = 0; i < count; ++i) column[i] = rows[block.rows[static_cast<size_t>(i)]];
    const Eigen::VectorXd white = block.root.triangularView<Eigen::Lower>().solve(column);
    for (Eigen::Index i = 0; i < count; ++i) out[block.rows[static_cast<size_t>(i)]] = white[i];
  }
  return out;
}

// A few numbers show no order that a test could find: that they miss at all is a structure.
std::vector<Structure> OutcomesProblem::structure(const Model& model, const Groups& groups,
                                                  int fitted) const {
  std::vector<Structure> found = Problem::structure(model, groups, fitted);
  const Evaluation here = evaluate(model, groups);
  for (size_t channel = 0; channel < facts_.channels.size(); ++channel) {
    const std::string& name = facts_.channels[channel].name;
    const ChannelMisfit misfit = misfit_of_channel(facts_, here, channel);
    if (misfit.count == 0) continue;
    const double looks = static_cast<double>(facts_.channels.size());
    add_missed_channel(found, name, "scenario", misfit, looks * misfit.p_value(), 1);
  }
  strongest_first(facts_, found);
  return found;
}

std::vector<RunsOfScenario> OutcomesProblem::runs(const Model& model) const {
  std::vector<RunsOfScenario> scenarios;
  for (size_t plan = 0; plan < predictor_->rows_of_plan().size(); ++plan) {
    std::set<size_t> columns;
    for (const size_t row : predictor_->rows_of_plan()[plan])
      columns.insert(rows_[row].statistic.column);
    const auto prediction = columns.empty() ? nullptr : predictor_->predict(plan, model);
    if (!prediction) continue;
    RunsOfScenario scenario{.scenario = settings_.runs.plans[plan].name, .values = {}, .table = {}};
    for (const size_t column : columns) {
      scenario.values.push_back(runs_->columns(plan)[column]);
      std::vector<double>& values = scenario.table.emplace_back();
      for (const std::vector<double>& run : prediction->table) values.push_back(run[column]);
    }
    scenarios.push_back(std::move(scenario));
  }
  return scenarios;
}

void OutcomesProblem::check_model(const Model& model) const {
  if (!effects::has_base(model, effects::Base::projection)) {
    throw InputError(
        fmt::format("model '{}': {} is missing: robots that run need a camera's projection",
                    model.name(), effects::base_name(effects::Base::projection)));
  }
}

bool OutcomesProblem::acts(const EffectDefinition& effect) const {
  const bool own = !effect.source.empty();  // Given beside the set, to be tried.
  const bool named = settings_.candidates && settings_.candidates->contains(effect.name);
  if (settings_.candidates && !own && !named) return false;
  // What nobody named is tried where it shows: noises in how statistics scatter, hardly in means.
  const bool shows = !effect.spread_only || named || tells_scatter(rows_);
  return shows && Problem::acts(effect);
}

std::optional<Bounds> OutcomesProblem::bounds(const std::string& effect,
                                              const std::string& parameter) const {
  if (!settings_.candidates) return std::nullopt;
  const auto stated = settings_.candidates->find(effect);
  if (stated == settings_.candidates->end()) return std::nullopt;
  const auto found = stated->second.find(parameter);
  return found == stated->second.end() ? std::nullopt : std::optional(found->second);
}

std::string OutcomesProblem::not_testable(const Model& model, const EffectDefinition& effect,
                                          size_t parameter) const {
  if (!settings_.candidates || !effect.source.empty())
    return Problem::not_testable(model, effect, parameter);
  // Of an effect whose parameters the set lists, those that it leaves out keep their neutral value.
  const auto listed = settings_.candidates->find(effect.name);
  const bool stated = listed != settings_.candidates->end() && !listed->second.empty();
  if (stated && !listed->second.contains(effect.parameters[parameter].name))
    return "the set's candidates do not name it";
  return Problem::not_testable(model, effect, parameter);
}

std::vector<std::vector<double>> OutcomesProblem::starts(const Model&,
                                                         const EffectDefinition& effect) const {
  const effects::StartRule& rule = effects::start_rule(effect, facts_.set.kind);
  if (rule.search == effects::StartSearch::listed) return rule.values;
  std::vector<std::vector<double>> all;
  for (const double sign : {0.0, -1.0}) {
    std::vector<double> start;
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const effects::Parameter& p = effect.parameters[i];
      if (p.integer) return {};
      const auto stated = bounds(effect.name, p.name);
      const double low = stated ? stated->low : p.min, high = stated ? stated->high : p.max;
      // Slopes are taken over steps that runs show: a start may be the neutral value itself, whose
      // runs are there already.
      double value = std::isfinite(p.neutral) ? p.neutral + 0.02 * sign * p.scale : 20 * p.scale;
      if (value < low || value > high) value = p.neutral - 0.02 * sign * p.scale;
      start.push_back(std::clamp(value, low, high));
    }
    if (all.empty() || start != all.back()) all.push_back(std::move(start));
  }
  return all;
}

std::vector<char> OutcomesProblem::find_outliers(const Model&) const {
  return std::vector<char>(rows_.size(), 0);
}

std::vector<std::string> OutcomesProblem::remarks(const Model&) const {
  std::vector<std::string> said = {fmt::format("{} runs were made, of at most {} (most_runs)",
                                               predictor_->made(), predictor_->most())};
  if (predictor_->spent()) {
    said.push_back(
        "the budget of runs was used up: what is not among the candidates was not tried, and fits "
        "may have stopped early; most_runs in measurement.yaml allows more");
  }
  return said;
}

Kind outcomes_kind() {
  return {.bit = effects::kOutcomes,
          .observations = {.file = "outcomes",
                           .keys = {"scenario", "value", "statistic"},
                           .measured = {"measured"}},
          .open = [](const MeasurementSet& set,
                     const Instruments& instruments) -> std::unique_ptr<Problem> {
            return std::make_unique<OutcomesProblem>(set, instruments);
          },
          .measure = measure_outcomes};
}

}  // namespace seam::measurement
