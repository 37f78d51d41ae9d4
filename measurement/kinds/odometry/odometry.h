// Kind `odometry`: walks filmed from above. The locomotion effects of a model predict each run's
// path from its commands; the true start of a run is a nuisance. With `walk_noise` the errors of a
// run are correlated: a Kalman filter over the run whitens them.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "effects/stages/locomotion.h"
#include "measurement/kinds/kinds.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {

struct WalkRun {
  std::string name;
  std::vector<size_t> rows;    // In the file.
  std::vector<double> time_s;  // Since the run's first row.
  std::vector<BodyVelocity> command;
  std::vector<std::array<double, 3>> pose;  // Measured x_m, y_m, theta_rad.
};

// Reads and checks odometry.csv. `measured` false: a protocol, poses are not read.
std::vector<WalkRun> read_walk_runs(const CsvTable& table, const std::string& group_column,
                                    bool measured);

// The path of a run by the model, from the origin facing +x: one state a row.
std::vector<effects::WalkState> predict_walk(const effects::Locomotion& walk, const WalkRun& run);

// One sigma of a single pose (x, y together, then theta), without a model: third differences of
// rows under one command, with the part that a random walk has in them taken out.
std::array<double, 3> noise_of_walks(const std::vector<WalkRun>& runs);

class OdometryProblem : public Problem {
 public:
  explicit OdometryProblem(const MeasurementSet& set);

  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* warm) const override;
  void check_model(const Model& model) const override;

 private:
  std::vector<effects::Lack> lacks() const;
  void describe(const MeasurementSet& set, const CsvTable& table);
  void add_covariates(const CsvTable& table, const std::string& group_column);
  void fit_start(const WalkRun& run, const std::vector<effects::WalkState>& path,
                 Evaluation& evaluation) const;
  void filter(const effects::Locomotion& walk, const WalkRun& run,
              const std::vector<effects::WalkState>& path, Evaluation& evaluation) const;

  std::vector<WalkRun> runs_;
  std::array<double, 3> noise_{};
};

// Makes the walks that the model would give (`seam measure`): each run starts at the origin,
// facing +x.
void measure_odometry(const Model& truth, const MeasurementSet& protocol,
                      const MeasureOptions& options);

Kind odometry_kind();

}  // namespace seam::measurement
