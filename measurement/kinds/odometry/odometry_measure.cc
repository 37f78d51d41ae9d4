// `seam measure` for odometry: the protocol's commands through the model's own walk.
#include <algorithm>
#include <cmath>

#include "effects/questions.h"
#include "measurement/kinds/odometry/odometry.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

// A run as its wheels rolled that counted so: each count is rounded, and rounds off the same as
// before for as long as the wheel hardly turns.
WalkRun rolled_behind_counts(const WalkRun& counted, RandomStream random) {
  WalkRun run = counted;
  const auto correlation = count_correlations(counted);
  std::array<double, 2> before{};
  for (size_t k = 0; k < run.ticks.size(); ++k) {
    for (size_t wheel = 0; wheel < 2; ++wheel) {
      const double fresh = uniform(random, 4 * k + 2 * wheel) - 0.5;
      const bool kept = k > 0 && uniform(random, 4 * k + 2 * wheel + 1) < correlation[k][wheel];
      const double error = kept ? before[wheel] : fresh;
      if (k > 0) run.ticks[k][wheel] += before[wheel] - error;
      before[wheel] = error;
    }
  }
  return run;
}

// A wandering pose: the model's path with the steps of walk_noise, each in the body's frame at the
// end of its interval.
std::vector<WalkPose> wander(const Model& truth, const WalkRun& run, RandomStream random,
                             bool noise) {
  const effects::Locomotion walk = effects::locomotion_of(truth);
  const auto path = predict_walk(walk, run, effects::timing_of(truth));
  WalkPose pose = placed({0, 0, 0}, path.front());
  std::vector<WalkPose> poses;
  for (size_t k = 0; k < path.size(); ++k) {
    if (k > 0) {
      const auto& from = path[k - 1];
      const double c0 = maths::cos(from.theta_rad), s0 = maths::sin(from.theta_rad);
      const double dx = path[k].x_m - from.x_m, dy = path[k].y_m - from.y_m;
      double along = c0 * dx + s0 * dy, across = -s0 * dx + c0 * dy,
             turn = path[k].theta_rad - from.theta_rad;
      const double root = noise ? std::sqrt(std::max(0.0, path[k].path_m - from.path_m)) : 0;
      const double nx = root * walk.xy_sigma * normal(random, 3 * k),
                   ny = root * walk.xy_sigma * normal(random, 3 * k + 1);
      const double c = maths::cos(pose[2]), s = maths::sin(pose[2]);
      // The slip is in the body's frame after the turn.
      const double ct = maths::cos(turn), st = maths::sin(turn);
      along += ct * nx - st * ny, across += st * nx + ct * ny;
      turn += root * walk.theta_sigma * normal(random, 3 * k + 2);
      pose = {pose[0] + c * along - s * across, pose[1] + s * along + c * across, pose[2] + turn};
    }
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace

void measure_odometry(const Model& truth, const MeasurementSet& protocol,
                      const MeasureOptions& options) {
  const CsvTable table = protocol.table("odometry");
  const auto runs = read_walk_runs(table, protocol.group, false);
  check_ticks(table, runs);
  const effects::Locomotion walk = effects::locomotion_of(truth);
  if (has_ticks(table) && !walk.wheels.driven)
    throw InputError(fmt::format("{} counts ticks of wheels, expected a model with {}",
                                 table.file(), effects::base_name(effects::Base::wheels)));
  const RandomStream random = RandomStream{options.seed, 0}.child("odometry");
  const std::vector<std::string> names(kPoseColumns.begin(), kPoseColumns.end());
  std::vector<std::vector<double>> measured(3, std::vector<double>(table.rows(), NAN));
  std::array<std::vector<char>, 3> blank;
  std::array<double, 3> of_set{};
  for (size_t c = 0; c < 3; ++c) {
    blank[c] = left_blank(table, names[c], names);
    of_set[c] = protocol.noise_of(names[c]);
  }
  const std::vector<effects::MovingNoise> noise = effects::noise_of(truth).pose;
  for (size_t i = 0; i < runs.size(); ++i) {
    const bool rounded = options.noise && !count_errors(runs[i]).empty();
    const auto poses = wander(
        truth, rounded ? rolled_behind_counts(runs[i], random.child("counts").child(i)) : runs[i],
        random.child("walk").child(i), options.noise);
    const PoseSigmas sigma =
        pose_sigmas(noise, of_set, runs[i], predict_walk(walk, runs[i], effects::timing_of(truth)));
    for (size_t k = 0; k < poses.size(); ++k) {
      const size_t row = runs[i].rows[k];
      for (int channel = 0; channel < 3; ++channel) {
        double value = poses[k][channel];
        if (options.noise) value += sigma[k][channel] * normal(random, 3 * row + channel);
        if (!blank[channel][row])
          measured[channel][row] = channel == 2 ? maths::wrap_angle(value) : value;
      }
    }
  }
  copy_protocol(protocol, options.out, {"odometry"});
  write_table_with(table, names, measured,
                   written_path(options.out, protocol.files.at("odometry")));
}

}  // namespace seam::measurement
