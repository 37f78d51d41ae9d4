#include "tools/experiments/head_swing/swing_runs.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "sim_core/base/maths.h"

namespace seam::tools {
namespace {

// Beyond this a region was taken for another landmark, which is not what is studied here.
constexpr double kWrongName_rad = 0.3;

effects::Timing timing_of_yaml(const std::string& model_yaml) {
  return effects::timing_of(
      effects::Model::from_config(ConfigNode::from_text(model_yaml, "a run's camera model")));
}

// The row of the full image that a row of the colour layer, which has half its rows, was taken
// from.
double full_row(double colour_row) {
  return std::floor(2 * (colour_row + 0.5));
}

std::vector<Sighting> sightings_of(const LoggedValues& values, const Pose2& truth,
                                   const effects::Timing& timing) {
  std::vector<Sighting> all;
  for (int landmark = 0; landmark < kBeacons; ++landmark) {
    const std::string name = fmt::format("landmark{}.", landmark);
    if (!values.contains(name + "bearing_rad")) continue;
    const auto& bearings = values.at(name + "bearing_rad");
    const auto& ranges = values.at(name + "range_m");
    const auto& rows = values.at(name + "row");
    const auto& pans = values.at(name + "pan_rad");
    const auto& times = values.at(name + "row_time_s");
    const double dx = kBeaconPlaces[landmark].x_m - truth.x_m,
                 dy = kBeaconPlaces[landmark].y_m - truth.y_m;
    const double true_bearing = maths::atan2(dy, dx) - truth.theta_rad,
                 true_range = std::sqrt(dx * dx + dy * dy);
    for (size_t i = 0; i < bearings.size(); ++i) {
      const double error = maths::wrap_angle(bearings[i].value - true_bearing);
      if (std::abs(error) > kWrongName_rad) continue;
      all.push_back({.time_s = times[i].value,
                     .landmark = landmark,
                     .bearing_error_rad = error,
                     .range_error = ranges[i].value > 0 ? ranges[i].value / true_range - 1
                                                        : std::numeric_limits<double>::quiet_NaN(),
                     .pan_rad = pans[i].value,
                     .pan_rate_radps = kSwing.rate_radps(times[i].value),
                     .row_middle_s = timing.row_middle_after_stamp_s(full_row(rows[i].value), 0)});
    }
  }
  return all;
}

}  // namespace

SwingRuns::SwingRuns(const ExperimentOptions& options) : options_(options) {}

void SwingRuns::plan(const SwingMode& mode, const std::vector<Pose2>& poses, int seeds) {
  for (int seed = 1; seed <= seeds; ++seed) {
    for (const Pose2& pose : poses) {
      PlannedRun run = pose_run(mode.name, mode.mode, pose, seed);
      if (names_.emplace(run.name, true).second) planned_[seed].push_back(std::move(run));
    }
  }
}

void SwingRuns::make() const {
  std::vector<PlannedRun> runs;
  for (const auto& [seed, of_seed] : planned_)
    runs.insert(runs.end(), of_seed.begin(), of_seed.end());
  make_runs(runs, options_.folder / "runs", options_.parallel);
}

SwingRun SwingRuns::read(const SwingMode& mode, const Pose2& pose, int seed) const {
  const PlannedRun planned = pose_run(mode.name, mode.mode, pose, seed);
  const LoggedValues values = logged_values(options_.folder / "runs" / (planned.name + ".mcap"));
  const PoseResult result = pose_result(values, planned.name, pose);
  SwingRun run{.dx_mm = 1e3 * (result.settled.x_m - pose.x_m),
               .dy_mm = 1e3 * (result.settled.y_m - pose.y_m)};
  run.bias_mm = std::sqrt(run.dx_mm * run.dx_mm + run.dy_mm * run.dy_mm);
  run.spread_mm = 1e3 * result.settled_spread_m;
  run.width_mm = 500 * (result.high.x_m - result.low.x_m + result.high.y_m - result.low.y_m);
  run.truth_inside = pose.x_m >= result.low.x_m && pose.x_m <= result.high.x_m &&
                     pose.y_m >= result.low.y_m && pose.y_m <= result.high.y_m;
  run.sightings =
      sightings_of(values, pose, timing_of_yaml(planned.scenario.robots.front().camera.model_yaml));
  return run;
}

std::vector<SwingRun> SwingRuns::read_all(const SwingMode& mode, const std::vector<Pose2>& poses,
                                          int seeds) const {
  std::vector<SwingRun> runs;
  for (int seed = 1; seed <= seeds; ++seed) {
    for (const Pose2& pose : poses) runs.push_back(read(mode, pose, seed));
  }
  return runs;
}

}  // namespace seam::tools
