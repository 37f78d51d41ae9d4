// What errors of a walk may depend on: taken from commands or ticks alone, so that no pose's noise
// stands on both sides of a regression.
#include <cmath>

#include "measurement/kinds/odometry/odometry.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// The start of a run by its first whole pose.
WalkPose rough_start(const WalkRun& run) {
  for (const WalkPose& pose : run.pose) {
    if (!std::isnan(pose[0] + pose[1] + pose[2])) return pose;
  }
  return {};
}

}  // namespace

void OdometryProblem::add_covariates(const effects::Locomotion& walk) {
  const size_t rows = facts_.rows();
  std::vector<double> time(rows), distance(rows), heading(rows), turn(rows), x(rows), y(rows),
      change(rows, 0), speed(rows, 0), turn_rate(rows, 0);
  for (const WalkRun& run : runs_) {
    // A count's rounding would stand on both sides of a regression as well.
    const auto path = predict_walk(walk, run, {}, Ticks::rolled);
    const WalkPose start = rough_start(run);
    double changed_s = 0;
    for (size_t k = 0; k < run.rows.size(); ++k) {
      const size_t row = run.rows[k];
      const auto pose = placed(start, path[k]);
      time[row] = run.time_s[k];
      distance[row] = path[k].path_m;
      turn[row] = path[k].theta_rad;
      heading[row] = maths::wrap_angle(pose[2]);
      x[row] = pose[0] - start[0];
      y[row] = pose[1] - start[1];
      if (k > 0) {
        const double dt = run.time_s[k] - run.time_s[k - 1];
        speed[row] = (path[k].path_m - path[k - 1].path_m) / dt;
        turn_rate[row] = (path[k].theta_rad - path[k - 1].theta_rad) / dt;
      }
      if (ticks_) continue;
      change[row] = run.time_s[k] - changed_s;
      if (k == 0 || run.command[k] != run.command[k - 1]) changed_s = run.time_s[k];
    }
  }
  facts_.combined.clear();
  if (facts_.channels.size() > 1 && facts_.channels[0].name == kPoseColumns[0] &&
      facts_.channels[1].name == kPoseColumns[1]) {
    // Errors of a step are along or across the body, whatever its heading in the room.
    CombinedChannel along{.name = "along_m", .channel_a = 0, .channel_b = 1};
    CombinedChannel across{.name = "across_m", .channel_a = 0, .channel_b = 1};
    for (const double h : heading) {
      along.weight_a.push_back(maths::cos(h)), along.weight_b.push_back(maths::sin(h));
      across.weight_a.push_back(-maths::sin(h)), across.weight_b.push_back(maths::cos(h));
    }
    facts_.combined = {along, across};
  }
  facts_.covariates.clear();
  const auto add = [&](const char* name, Covariate::Type type, std::vector<double> values,
                       bool products) {
    facts_.covariates.push_back({name, type, std::move(values), products});
  };
  add("time", Covariate::Type::smooth, std::move(time), true);
  add("distance", Covariate::Type::smooth, std::move(distance), true);
  add("turn", Covariate::Type::smooth, std::move(turn), true);
  add("heading", Covariate::Type::cyclic, std::move(heading), true);
  add("x_moved", Covariate::Type::smooth, std::move(x), false);
  add("y_moved", Covariate::Type::smooth, std::move(y), false);
  if (ticks_) {
    add("speed", Covariate::Type::smooth, std::move(speed), false);
    add("heading_rate", Covariate::Type::smooth, std::move(turn_rate), false);
  } else {
    add("time_since_change", Covariate::Type::smooth, std::move(change), false);
  }
  facts_.covariates.insert(facts_.covariates.end(), columns_.begin(), columns_.end());
}

}  // namespace seam::measurement
