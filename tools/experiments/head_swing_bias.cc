// What locking the camera's frames to the head's swing does to localisation, and what the rolling
// shutter adds in each direction of swing: theory beside measurement.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "effects/timing.h"
#include "sim_core/files.h"
#include "sim_core/maths.h"
#include "tools/experiments/experiments.h"
#include "tools/experiments/plot.h"
#include "tools/experiments/pose_runs.h"
#include "tools/experiments/statistics.h"

namespace seam::tools {
namespace {

struct Mode {
  std::string name;
  PoseMode mode;
};

// Bearing errors of all sightings of a run, apart by direction of swing.
struct BearingErrors {
  std::vector<double> left_rad, right_rad;                // Head turning left, right.
  std::vector<double> theory_left_rad, theory_right_rad;  // By the rolling shutter alone.
};

struct Outcome {
  std::vector<double> bias_mm, spread_mm;  // One value a run: |mean of the settled estimates - truth|.
  BearingErrors bearings;
};

struct Place {
  double x_m, y_m;
};
// By LandmarkKind of the SDK: beacons by their other colour and whether pink is low, then goals.
constexpr Place kLandmarks[] = {{-2.2, 1.45}, {-2.2, -1.45}, {2.2, 1.45}, {2.2, -1.45}, {0, 1.45}, {0, -1.45}};

void add_bearings(const LoggedValues& values, const Pose2& truth, const effects::Timing& timing, bool row_times,
                  BearingErrors& errors) {
  for (size_t kind = 0; kind < std::size(kLandmarks); ++kind) {
    const std::string name = fmt::format("landmark{}", kind);
    if (!values.contains(name + ".bearing_rad")) continue;
    const auto& bearings = values.at(name + ".bearing_rad");
    const auto& rows = values.at(name + ".row");
    const auto& rates = values.at(name + ".pan_rate");
    const double true_bearing =
        maths::atan2(kLandmarks[kind].y_m - truth.y_m, kLandmarks[kind].x_m - truth.x_m) - truth.theta_rad;
    for (size_t i = 0; i < bearings.size(); ++i) {
      const double error = maths::wrap_angle(bearings[i].value - true_bearing);
      // Wrongly named regions are not what is studied here.
      if (std::abs(error) > 0.3 || std::abs(rates[i].value) < 0.2) continue;
      // A client that takes the head's angle at the frame's stamp misses what it turned since then.
      const double theory = row_times ? 0 : -rates[i].value * timing.row_middle_after_stamp_s(rows[i].value, 0);
      const bool left = rates[i].value > 0;
      (left ? errors.left_rad : errors.right_rad).push_back(error);
      (left ? errors.theory_left_rad : errors.theory_right_rad).push_back(theory);
    }
  }
}

class Study {
 public:
  Study(const ExperimentOptions& options, std::vector<Pose2> poses, int seeds)
      : options_(options), poses_(std::move(poses)), seeds_(seeds) {
    const Scenario base = Scenario::from_file(data_file("scenarios/localization.yaml"));
    timing_ = effects::timing_of(effects::Model::from_config(
        ConfigNode::from_text(base.robots.front().camera.model_yaml, "the scenario's camera model")));
  }

  void plan(const Mode& mode, std::vector<PlannedRun>& runs) const {
    for (int seed = 1; seed <= seeds_; ++seed) {
      for (const Pose2& pose : poses_) runs.push_back(pose_run(mode.name, mode.mode, pose, seed));
    }
  }

  Outcome read(const Mode& mode) const {
    Outcome outcome;
    for (int seed = 1; seed <= seeds_; ++seed) {
      for (const Pose2& pose : poses_) {
        const PoseResult result = read_pose_run(options_.folder / "runs", mode.name, pose, seed);
        const double dx = result.settled.x_m - pose.x_m, dy = result.settled.y_m - pose.y_m;
        outcome.bias_mm.push_back(1e3 * std::sqrt(dx * dx + dy * dy));
        outcome.spread_mm.push_back(1e3 * result.settled_spread_m);
        const std::string log = pose_run(mode.name, mode.mode, pose, seed).name + ".mcap";
        add_bearings(logged_values(options_.folder / "runs" / log), pose, timing_, mode.mode.row_times, outcome.bearings);
      }
    }
    return outcome;
  }

  // One value a seed (mean over poses) where there are several seeds, else one a run.
  std::vector<double> replicates(const std::vector<double>& by_run) const {
    if (seeds_ < 3) return by_run;
    std::vector<double> means;
    for (int seed = 0; seed < seeds_; ++seed) {
      const auto first = by_run.begin() + seed * static_cast<long>(poses_.size());
      means.push_back(mean_of({first, first + static_cast<long>(poses_.size())}));
    }
    return means;
  }

  int seeds() const { return seeds_; }

 private:
  const ExperimentOptions& options_;
  std::vector<Pose2> poses_;
  int seeds_;
  effects::Timing timing_;
};

nlohmann::json bounds(const Interval& interval) {
  return {interval.mean - interval.half_width, interval.mean + interval.half_width};
}

nlohmann::json main_comparison(const Study& study, const Mode& locked, const Mode& scheduled) {
  const Outcome a = study.read(locked), b = study.read(scheduled);
  std::vector<double> differences;
  for (size_t i = 0; i < a.bias_mm.size(); ++i) differences.push_back(a.bias_mm[i] - b.bias_mm[i]);
  const auto mode_json = [&](const Outcome& outcome) -> nlohmann::json {
    const Interval bias = interval_of(study.replicates(outcome.bias_mm));
    return {{"bias_mm", bias.mean}, {"ci95", bounds(bias)}, {"spread_mm", mean_of(outcome.spread_mm)}};
  };
  const Interval paired = interval_of(study.replicates(differences));
  std::printf("position bias: locked %.1f mm, scheduled %.1f mm; paired difference %.1f +- %.1f mm (95 %%), %d seeds\n",
              mean_of(a.bias_mm), mean_of(b.bias_mm), paired.mean, paired.half_width, study.seeds());
  return {{"format", "seam-head-swing-bias/1"},
          {"modes", {{"locked", mode_json(a)}, {"scheduled", mode_json(b)}}},
          {"paired", {{"difference_mm", paired.mean}, {"ci95", bounds(paired)}}},
          {"seeds", study.seeds()}};
}

void draw(const std::filesystem::path& folder) {
  plot(folder, "head_swing_position",
       "set logscale x 2\nset key right top\nset xlabel 'frames in one swing of the head'\n"
       "set ylabel 'position bias [mm]'\nset yrange [0:*]\n"
       "plot '< grep ^locked,1 sweep.csv' using 3:4:5 with yerrorlines ls 1 title 'locked, row times used', \\\n"
       "  '< grep ^scheduled,1 sweep.csv' using 3:4:5 with yerrorlines ls 3 title 'scheduled, row times used', \\\n"
       "  '< grep ^locked,0 sweep.csv' using 3:4:5 with yerrorlines ls 2 title 'locked, one time a frame'\n");
  plot(folder, "head_swing_bearing",
       "set logscale x 2\nset key right center\nset xlabel 'frames in one swing of the head'\n"
       "set ylabel 'mean bearing error [rad]'\n"
       "plot '< grep ^locked,0 sweep.csv' using 3:6 with points ls 1 title 'head turning left, measured', \\\n"
       "  '< grep ^locked,0 sweep.csv' using 3:7 with lines ls 1 title 'left, theory', \\\n"
       "  '< grep ^locked,0 sweep.csv' using 3:8 with points ls 2 title 'head turning right, measured', \\\n"
       "  '< grep ^locked,0 sweep.csv' using 3:9 with lines ls 2 title 'right, theory', \\\n"
       "  '< grep ^locked,1 sweep.csv' using 3:6 with points ls 3 title 'left, row times used'\n");
}

}  // namespace

void head_swing_bias_experiment(const ExperimentOptions& options) {
  const Study study(options, paper_poses(options.quick ? 4 : 12), options.quick ? 1 : options.seeds);
  const Mode locked{"locked", {.locked = true}}, scheduled{"scheduled", {.locked = false}};
  std::vector<PlannedRun> runs;
  study.plan(locked, runs);
  study.plan(scheduled, runs);

  // How it depends on the number of frames in a swing: with few, a locked camera sees few angles.
  const Study sweep(options, paper_poses(4), 1);
  std::vector<Mode> modes;
  for (const int frames : options.quick ? std::vector<int>{6, 101} : std::vector<int>{4, 6, 8, 12, 16, 25, 50, 101}) {
    for (const bool is_locked : {true, false}) {
      for (const bool row_times : {true, false}) {
        modes.push_back({fmt::format("sweep_{}{}_{}", is_locked ? "locked" : "scheduled", row_times ? 1 : 0, frames),
                         {.locked = is_locked, .frames_per_swing = frames, .row_times = row_times}});
      }
    }
  }
  for (const Mode& mode : modes) sweep.plan(mode, runs);
  make_runs(runs, options.folder / "runs", options.parallel);

  nlohmann::json json = main_comparison(study, locked, scheduled);
  std::string csv =
      "clock,row_times,frames_per_swing,bias_mm,bias_ci95_mm,left_rad,left_theory_rad,right_rad,right_theory_rad\n";
  for (const Mode& mode : modes) {
    const Outcome outcome = sweep.read(mode);
    const Interval bias = interval_of(outcome.bias_mm);
    csv += fmt::format("{},{},{},{:.2f},{:.2f},{:.5f},{:.5f},{:.5f},{:.5f}\n", mode.mode.locked ? "locked" : "scheduled",
                       mode.mode.row_times ? 1 : 0, mode.mode.frames_per_swing, bias.mean, bias.half_width,
                       mean_of(outcome.bearings.left_rad), mean_of(outcome.bearings.theory_left_rad),
                       mean_of(outcome.bearings.right_rad), mean_of(outcome.bearings.theory_right_rad));
    json["sweep"].push_back({{"clock", mode.mode.locked ? "locked" : "scheduled"}, {"row_times", mode.mode.row_times},
                             {"frames_per_swing", mode.mode.frames_per_swing}, {"bias_mm", bias.mean},
                             {"bearing_left_rad", mean_of(outcome.bearings.left_rad)},
                             {"bearing_left_theory_rad", mean_of(outcome.bearings.theory_left_rad)},
                             {"bearing_right_rad", mean_of(outcome.bearings.right_rad)},
                             {"bearing_right_theory_rad", mean_of(outcome.bearings.theory_right_rad)}});
  }
  write_file_atomically(options.folder / "sweep.csv", csv);
  draw(options.folder);
  if (!options.json_file.empty()) write_file_atomically(options.json_file, json.dump(1) + "\n");
}

}  // namespace seam::tools
