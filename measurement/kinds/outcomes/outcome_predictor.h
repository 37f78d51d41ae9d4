// Statistics that a model predicts for each scenario of a set: made by runs of the simulator, with
// the same seeds for every model, kept, and counted against a budget.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "measurement/kinds/outcomes/outcomes_data.h"
#include "measurement/kinds/outcomes/scatter_of_runs.h"

namespace seam::measurement {

// What a scenario's runs say of its rows.
struct ScenarioPrediction {
  StatisticsOfRuns statistics;  // By row of the scenario, in the order of the set.
  size_t runs = 0;
  Eigen::MatrixXd scatter;  // Covariance of the statistics of as many other runs.
  size_t told_by = 0;       // So many runs tell it.
  std::string first_error;
  std::vector<std::vector<double>> table;  // What each run kept, by the plan's own seeds.
};

class OutcomePredictor {
 public:
  OutcomePredictor(const OutcomeSettings& settings, RunMaker& runs,
                   const std::vector<OutcomeRow>& rows);

  // Finds how far statistics of the plan scatter, with the given model; false where the budget of
  // runs does not allow it. Called once, before anything is predicted.
  bool learn_scatter(size_t plan, const effects::Model& given);

  // Null where the budget of runs is used up. Thread-safe; equal models give equal bits.
  std::shared_ptr<const ScenarioPrediction> predict(size_t plan, const effects::Model& asked) const;

  // Rows of the set by scenario.
  const std::vector<std::vector<size_t>>& rows_of_plan() const { return rows_of_plan_; }
  uint64_t made() const;
  uint64_t most() const { return most_; }
  bool spent() const;

 private:
  // Of the given model.
  struct Reference {
    Scatter scatter;
    Eigen::MatrixXd by_table;  // Its covariance from the runs of one table,
    RunTable table;            // this one, by the plan's own seeds,
    std::string key;           // and what it depends on.
  };

  RunSpec spec_;
  RunMaker& runs_;
  uint64_t most_;
  std::vector<std::vector<size_t>> rows_of_plan_;
  std::vector<std::vector<ColumnStatistic>> wanted_;  // By scenario.
  std::vector<std::optional<Reference>> given_;       // By scenario.
  mutable std::mutex mutex_;
  mutable std::map<std::string, std::shared_ptr<const ScenarioPrediction>> known_;
  mutable uint64_t made_ = 0;
  mutable bool spent_ = false;
};

}  // namespace seam::measurement
