// Kind `odometry`: walks and drives filmed from above. The locomotion effects of a model predict
// each run's path from its commands or from the ticks of its wheels; the true start of a run is a
// nuisance. With `walk_noise` the errors of a run are correlated: a Kalman filter over the run
// whitens them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "effects/stages/noise.h"
#include "effects/stages/timing.h"
#include "effects/stages/walk/locomotion.h"
#include "measurement/kinds/kinds.h"
#include "measurement/kinds/odometry/tick_errors.h"
#include "measurement/kinds/odometry/walk_run.h"
#include "measurement/problem/memo.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {

// Reads and checks odometry.csv. `measured` false: a protocol, poses are not read. Of rows of one
// time the first counts; `repeated` gets how many did not.
std::vector<WalkRun> read_walk_runs(const CsvTable& table, const std::string& group_column,
                                    bool measured, size_t* repeated = nullptr);

// Columns of such a table that are no further ones.
std::vector<std::string> walk_columns(const std::string& group_column);

// Whether a table tells of wheels' ticks, not of commanded velocities.
bool has_ticks(const CsvTable& table);

// Throws InputError where ticks are none since the row before: a counter that goes on, wraps around
// or was reset.
void check_ticks(const CsvTable& table, const std::vector<WalkRun>& runs);

// Ticks as they were counted, or as the wheels may have rolled in the mean that counted so.
enum class Ticks { counted, rolled };

// The path of a run by the model, from the origin facing +x: the state at each row's pose, whose
// true time `timing` tells. Before the first row the body rests.
std::vector<effects::WalkState> predict_walk(const effects::Locomotion& walk, const WalkRun& run,
                                             const effects::Timing& timing = {},
                                             Ticks as = Ticks::counted);

// From what has moved in a start's own frame to poses; asks for the start's sine and cosine once.
class From {
 public:
  explicit From(const WalkPose& start);
  WalkPose operator()(const WalkPose& moved) const;
  WalkPose operator()(const effects::WalkState& moved) const {
    return (*this)(WalkPose{moved.x_m, moved.y_m, moved.theta_rad});
  }

 private:
  WalkPose start_;
  double cosine_, sine_;
};
// A pose that starts at `start` and has moved to `moved` in the start's own frame.
inline WalkPose placed(const WalkPose& start, const WalkPose& moved) {
  return From(start)(moved);
}
inline WalkPose placed(const WalkPose& start, const effects::WalkState& moved) {
  return placed(start, WalkPose{moved.x_m, moved.y_m, moved.theta_rad});
}
// What was seen less what was predicted; NaN where blank.
WalkPose missed(const WalkPose& seen, const WalkPose& predicted);
// The motion from one state to the next, in the first one's body frame.
effects::WalkState between(const effects::WalkState& from, const effects::WalkState& to);

// One sigma of a single pose (x, y together, then theta), without a model: third differences of
// rows under one command, with the part that a random walk has in them taken out.
std::array<double, 3> noise_of_walks(const std::vector<WalkRun>& runs);

// One sigma of x, y and theta at each row: that of the set and what the motion before the row adds.
using PoseSigmas = std::vector<std::array<double, 3>>;
PoseSigmas pose_sigmas(const std::vector<effects::MovingNoise>& noise,
                       const std::array<double, 3>& of_set, const WalkRun& run,
                       const std::vector<effects::WalkState>& path);

class OdometryProblem : public Problem {
 public:
  explicit OdometryProblem(const MeasurementSet& set);

  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* warm) const override;
  void check_model(const Model& model) const override;
  std::vector<std::string> formula_columns() const override { return runs_.front().further->names; }
  std::vector<FreeError> free_prediction(const Model& model, const Groups& groups) const override;
  // On ways and turns: an error of either moves all later poses.
  std::vector<FieldPlace> field_places(const Model& model, const Evaluation& here) const override;
  // Each direction in which a run goes or turns.
  std::vector<Groups> regimes() const override;

 protected:
  void place(const Model& given) override;

 private:
  struct Start {
    WalkPose pose{};
    int unknowns = 0;  // As many of its numbers as poses tell.
    // Of the poses' covariance where the first pose tells the start: errors of each pose alone.
    double log_det = 0;
  };

  // A run's path by a model, the motion to each row from the one before it, and what the counts of
  // its wheels round off; empty: nothing that matters.
  struct Walked {
    std::vector<effects::WalkState> path;
    std::vector<WalkPose> steps;
    CountErrors counted;
  };

  // By row, of the step since the row before: relative changes of its way and of its turn, and how
  // far it turns and goes aside for each metre of its way.
  struct Stretch {
    std::vector<double> way, turn, turn_of_way, aside;
  };

  // Of x, y and heading; 0 of what is not measured.
  std::array<double, 3> noise_of_set() const {
    std::array<double, 3> noise{};
    for (size_t i = 0; i < noise.size(); ++i) {
      if (channel_of_pose_[i] >= 0) noise[i] = facts_.channels[channel_of_pose_[i]].noise;
    }
    return noise;
  }
  Ticks ticks_as(const effects::Locomotion& walk) const {
    return counting_matters(walk.wheels, noise_of_set()) ? Ticks::rolled : Ticks::counted;
  }
  Evaluation evaluate_walks(const Model& model, const Groups& groups, const Stretch* stretch) const;
  Walked walked_by(const effects::Locomotion& walk, const WalkRun& run,
                   const effects::Timing& timing) const;
  static Walked stretched(const Walked& walked, const WalkRun& run, const Stretch& by);
  std::vector<effects::Lack> lacks(const effects::Wheels& wheels) const;
  void describe(const MeasurementSet& set, const CsvTable& table);
  void add_covariates(const effects::Locomotion& walk);
  Start fit_start(const WalkRun& run, size_t rows, const std::vector<effects::WalkState>& path,
                  const PoseSigmas& sigma) const;
  void take_start(const WalkRun& run, const WalkPose& start,
                  const std::vector<effects::WalkState>& path, const PoseSigmas& sigma,
                  Evaluation& evaluation) const;
  double log_det_of(const WalkRun& run, const Eigen::Matrix3d& information,
                    const PoseSigmas& sigma) const;
  // Gives log det S of the run.
  double filter(const effects::Locomotion& walk, const WalkRun& run, const Start& start,
                const Walked& walked, const PoseSigmas& sigma, Evaluation& evaluation) const;
  template <int N>
  double filter(const effects::Locomotion& walk, const WalkRun& run, const Start& start,
                const Walked& walked, const PoseSigmas& sigma, Evaluation& evaluation) const;
  // Of a channel of a row; -1 where blank.
  int scalar(size_t row, int channel) const { return scalars_[row][channel]; }
  bool takes_part(size_t row, int channel) const {
    return scalar(row, channel) >= 0 && !left_out(scalar(row, channel));
  }
  bool is_whole(const WalkRun& run, size_t k) const {
    return takes_part(run.rows[k], 0) && takes_part(run.rows[k], 1) && takes_part(run.rows[k], 2);
  }

  std::vector<WalkRun> runs_;
  std::optional<Memo<Walked>> paths_;        // By run.
  std::optional<Memo<Start>> starts_;        // By run.
  std::vector<std::array<int, 3>> scalars_;  // By row.
  std::vector<Covariate> columns_;           // Covariates that the table holds.
  bool ticks_ = false;
  std::array<int, 3> channel_of_pose_ = {-1, -1, -1};  // Of x, y and heading; -1: not measured.
};

// Makes the walks that the model would give (`seam measure`): each run starts at the origin,
// facing +x.
void measure_odometry(const Model& truth, const MeasurementSet& protocol,
                      const MeasureOptions& options);

Kind odometry_kind();

}  // namespace seam::measurement
