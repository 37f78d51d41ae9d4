// Kind `outcomes` as the engine sees it: one residual a statistic of whole runs.
//
// A prediction is made of finitely many runs, whose own scatter stands in the covariance beside the
// errors of what was measured. Every model is run with the same seeds (common random numbers), so
// that differences between models are known far better than either. Noises of the simulated robot
// change predictions here as any other effect does.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "measurement/kinds/kinds.h"
#include "measurement/kinds/outcomes/outcome_predictor.h"

namespace seam::measurement {

// What each run of a scenario kept: of those values that the set has numbers of.
struct RunsOfScenario {
  std::string scenario;
  std::vector<std::string> values;         // Names.
  std::vector<std::vector<double>> table;  // By value, by run; NaN where a run gave none.
};

class OutcomesProblem : public Problem {
 public:
  OutcomesProblem(const MeasurementSet& set, const Instruments& instruments);

  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* warm = nullptr) const override;
  std::vector<std::vector<double>> jacobian(const Model& model,
                                            const std::vector<Unknown>& unknowns,
                                            const Groups& groups,
                                            const Evaluation& here) const override;
  Fit fit(const Model& start, const std::vector<Unknown>& unknowns,
          const Groups& groups) const override;
  std::vector<Structure> structure(const Model& model, const Groups& groups,
                                   int fitted) const override;
  void check_model(const Model& model) const override;
  bool is_smooth(const Model&) const override { return true; }
  std::optional<Groups> screening_groups() const override { return all_groups(); }
  bool acts(const EffectDefinition& effect) const override;
  std::string not_testable(const Model& model, const EffectDefinition& effect,
                           size_t parameter) const override;
  std::vector<std::vector<double>> starts(const Model& model,
                                          const EffectDefinition& effect) const override;
  std::vector<char> find_outliers(const Model& model) const override;
  std::string no_outliers_because() const override { return "each number stands for many runs"; }
  std::vector<std::string> remarks(const Model& model) const override;

  // Derivatives of predictions by a coordinate, by row, over a step that the set notices. `step`
  // is the one to begin with, and gets the one taken. Empty where nothing near can be predicted.
  std::vector<double> slope(const Model& model, const struct Coordinate& coordinate,
                            const Groups& groups, double& step) const;
  // Rows whitened by the covariance that this model predicts.
  std::vector<double> whitened_by(const Model& model, const Groups& groups,
                                  const std::vector<double>& rows) const;
  // With this model, by the plans' own seeds; none where the budget of runs is used up.
  std::vector<RunsOfScenario> runs(const Model& model) const;
  // The range of a parameter that the set states; nothing: it states none.
  std::optional<Bounds> bounds(const std::string& effect, const std::string& parameter) const;

 protected:
  void place(const Model& given) override;

 private:
  // Rows whose errors hang together, with the Cholesky factor of their covariance.
  struct Block {
    int group = 0;
    std::vector<size_t> rows;
    Eigen::MatrixXd root;
  };
  // By row; false where it cannot be predicted.
  bool predict(const Model& model, const Groups& groups, std::vector<double>& values) const;
  std::vector<Block> blocks_of(const Model& model, const Groups& groups) const;

  OutcomeSettings settings_;
  std::unique_ptr<RunMaker> runs_;
  std::vector<OutcomeRow> rows_;
  std::unique_ptr<OutcomePredictor> predictor_;
};

// `seam measure` for this kind (outcomes_measure.cc).
void measure_outcomes(const Model& truth, const MeasurementSet& protocol,
                      const MeasureOptions& options, const Instruments& instruments);

// Opens the simulator for a set's plans; throws InputError where this program has none.
std::unique_ptr<RunMaker> open_runs(const MeasurementSet& set, const OutcomeSettings& settings,
                                    const Instruments& instruments);

}  // namespace seam::measurement
