#include "measurement/kinds/outcomes/outcome_predictor.h"

#include <fmt/format.h>

namespace seam::measurement {
namespace {

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
    : runs_(runs),
      most_(settings.most_runs),
      rows_of_plan_(settings.runs.plans.size()),
      wanted_(settings.runs.plans.size()) {
  for (size_t row = 0; row < rows.size(); ++row) {
    rows_of_plan_[rows[row].plan].push_back(row);
    wanted_[rows[row].plan].push_back(rows[row].statistic);
  }
}

std::shared_ptr<const ScenarioPrediction> OutcomePredictor::predict(
    size_t plan, const effects::Model& model) const {
  const std::string key = key_of(plan, model);
  const std::lock_guard lock(mutex_);
  if (const auto found = known_.find(key); found != known_.end()) return found->second;
  const uint64_t cost = runs_.runs(plan);
  if (made_ + cost > most_) {
    spent_ = true;
    return nullptr;
  }
  made_ += cost;
  RunTable table = runs_.make(plan, model, /*draw=*/0);
  const auto prediction = std::make_shared<const ScenarioPrediction>(
      ScenarioPrediction{.statistics = statistics_of(table.runs, runs_.alike(plan), wanted_[plan]),
                         .runs = table.runs.size(),
                         .first_error = std::move(table.first_error)});
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
