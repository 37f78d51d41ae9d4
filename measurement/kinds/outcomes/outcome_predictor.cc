#include "measurement/kinds/outcomes/outcome_predictor.h"

#include <fmt/format.h>

namespace seam::measurement {
namespace {

// Without effects at their neutral values, which change nothing: such models share their runs.
effects::Model without_neutral(effects::Model model) {
  std::vector<std::string> idle;
  for (const effects::ModelEffect& effect : model.effects()) {
    const auto& parameters = effect.definition->parameters;
    bool neutral = effect.definition->has_neutral && !parameters.empty();
    for (size_t i = 0; i < parameters.size(); ++i)
      neutral = neutral && effect.parameters[i].value == parameters[i].neutral &&
                effect.parameters[i].spread == 0;
    if (neutral) idle.push_back(effect.definition->name);
  }
  for (const std::string& name : idle) model.remove(name);
  return model;
}

std::string key_of(size_t plan, const effects::Model& model) {
  std::string key = fmt::format("{}", plan);
  for (const effects::ModelEffect& effect : model.effects()) {
    key += fmt::format("\n{} {}", effect.definition->name, effect.definition->source);
    for (const double value : effect.values()) key += fmt::format(" {:.17g}", value);
  }
  return key;
}

}  // namespace

OutcomePredictor::OutcomePredictor(const OutcomeSettings& settings, RunMaker& runs,
                                   const std::vector<OutcomeRow>& rows)
    : spec_(settings.runs),
      runs_(runs),
      most_(settings.most_runs),
      rows_of_plan_(settings.runs.plans.size()),
      wanted_(settings.runs.plans.size()),
      given_(settings.runs.plans.size()) {
  for (size_t row = 0; row < rows.size(); ++row) {
    rows_of_plan_[rows[row].plan].push_back(row);
    wanted_[rows[row].plan].push_back(rows[row].statistic);
  }
}

bool OutcomePredictor::learn_scatter(size_t plan, const effects::Model& given) {
  const uint64_t further = runs_.runs(plan) * further_tables(spec_, runs_, plan);
  const std::lock_guard lock(mutex_);
  if (made_ + runs_.runs(plan) + further > most_) {
    spent_ = true;
    return false;
  }
  made_ += further;  // The first table counts when it is asked for.
  const effects::Model model = without_neutral(given);
  RunTable table = runs_.make(plan, model, /*draw=*/0);
  const StatisticsOfRuns of_table = statistics_of(table.runs, runs_.alike(plan), wanted_[plan]);
  Scatter scatter = scatter_of(spec_, runs_, plan, model, table, wanted_[plan], /*stream=*/0);
  given_[plan] = {std::move(scatter), of_table.covariance, std::move(table), key_of(plan, model)};
  return true;
}

std::shared_ptr<const ScenarioPrediction> OutcomePredictor::predict(
    size_t plan, const effects::Model& asked) const {
  const effects::Model model = without_neutral(asked);
  const std::string key = key_of(plan, model);
  const std::lock_guard lock(mutex_);
  if (const auto found = known_.find(key); found != known_.end()) return found->second;
  const uint64_t cost = runs_.runs(plan);
  if (made_ + cost > most_) {
    spent_ = true;
    return nullptr;
  }
  made_ += cost;
  const auto& given = given_[plan];
  RunTable table = given && given->key == key ? given->table : runs_.make(plan, model, /*draw=*/0);
  ScenarioPrediction made{.statistics = statistics_of(table.runs, runs_.alike(plan), wanted_[plan]),
                          .runs = table.runs.size(),
                          .told_by = table.runs.size(),
                          .first_error = std::move(table.first_error),
                          .table = std::move(table.runs)};
  Eigen::MatrixXd& covariance = made.statistics.covariance;
  made.scatter = covariance;
  if (given) {
    // Equal seeds: the given model, known from more runs, tells how far these runs lie off.
    const Scatter& scatter = given->scatter;
    made.scatter = scatter_beside(scatter.covariance, given->by_table, covariance, made.runs);
    made.told_by = made.runs * scatter.tables;
    covariance = made.scatter / static_cast<double>(scatter.tables);
    for (size_t k = 0; k < scatter.beyond.size(); ++k)
      made.statistics.value[k] += scatter.beyond[k];
  }
  const auto prediction = std::make_shared<const ScenarioPrediction>(std::move(made));
  known_.emplace(key, prediction);
  return prediction;
}

uint64_t OutcomePredictor::made() const {
  const std::lock_guard lock(mutex_);
  return made_;
}

bool OutcomePredictor::spent() const {
  const std::lock_guard lock(mutex_);
  return spent_;
}

}  // namespace seam::measurement
