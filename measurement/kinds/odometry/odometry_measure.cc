// `seam measure` for odometry: the protocol's commands through the model's own walk.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "effects/questions.h"
#include "measurement/kinds/odometry/odometry.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

// A run as its wheels may have rolled that counted so, with rows at its own times and at those of
// its poses, which lie between them.
WalkRun rolled_behind_counts(const WalkRun& counted, const effects::Timing& timing,
                             RandomStream random) {
  WalkRun run{.name = counted.name, .time_s = counted.time_s};
  for (const double t_s : counted.time_s) {
    const double pose_s = t_s + timing.row_middle_after_stamp_s(0, t_s);
    if (pose_s > 0 && pose_s < counted.time_s.back()) run.time_s.push_back(pose_s);
  }
  std::sort(run.time_s.begin(), run.time_s.end());
  run.time_s.erase(std::unique(run.time_s.begin(), run.time_s.end()), run.time_s.end());
  run.rows.resize(run.time_s.size());
  run.ticks.assign(run.time_s.size(), {0, 0});
  run.slip_ticks = run.ticks;
  std::array<Eigen::Vector2d, 2> error;  // Of way and speed.
  size_t row = 0;                        // That begins after this time.
  for (size_t k = 0; k < run.time_s.size(); ++k) {
    const double before_s = k > 0 ? run.time_s[k - 1] : 0;
    while (row + 1 < counted.time_s.size() && counted.time_s[row] <= before_s) ++row;
    const double share =
        row > 0 ? (run.time_s[k] - before_s) / (counted.time_s[row] - counted.time_s[row - 1]) : 0;
    for (size_t wheel = 0; wheel < 2; ++wheel) {
      const RolledWay& way = counted.ways[wheel];
      const RolledWay::Step step = way.step(before_s, run.time_s[k]);
      const uint64_t draw = 4 * k + 2 * wheel;
      const Eigen::Vector2d drawn(normal(random, draw), normal(random, draw + 1));
      const Eigen::Matrix2d fresh = k > 0 ? step.fresh : way.at_start();
      const Eigen::Vector2d before = k > 0 ? error[wheel] : Eigen::Vector2d::Zero().eval();
      error[wheel] = step.kept * before + fresh.llt().matrixL() * drawn;
      if (k == 0) continue;
      run.ticks[k][wheel] = share * counted.rolled_ticks[row][wheel] + error[wheel][0] - before[0];
      run.slip_ticks[k][wheel] = share * counted.slip_ticks[row][wheel];
    }
  }
  return run;
}

// The path of a run, with wheels as they may have rolled.
std::vector<effects::WalkState> rolled_path(const effects::Locomotion& walk, const WalkRun& counted,
                                            const effects::Timing& timing, RandomStream random) {
  const WalkRun run = rolled_behind_counts(counted, timing, random);
  const std::vector<effects::WalkState> path = predict_walk(walk, run, timing);
  std::vector<effects::WalkState> of_rows;
  for (size_t k = 0; k < path.size() && of_rows.size() < counted.time_s.size(); ++k) {
    if (run.time_s[k] == counted.time_s[of_rows.size()]) of_rows.push_back(path[k]);
  }
  return of_rows;
}

// A wandering pose: a path with the steps of walk_noise, each in the body's frame at the end of its
// interval.
std::vector<WalkPose> wander(const effects::Locomotion& walk,
                             const std::vector<effects::WalkState>& path, RandomStream random,
                             bool noise) {
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
      const double more = root * walk.theta_sigma * normal(random, 3 * k + 2);
      turn += more;
      // The measured point swings round the axle by what the body turns more.
      const std::array<double, 2> swing = walk.tracker.by_turn(ct, st);
      along += more * swing[0], across += more * swing[1];
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
  const effects::Timing timing = effects::timing_of(truth);
  for (size_t i = 0; i < runs.size(); ++i) {
    const Ticks as = counting_matters(walk.wheels, of_set) ? Ticks::rolled : Ticks::counted;
    const auto mean = predict_walk(walk, runs[i], timing, as);
    const bool rounded = options.noise && !runs[i].ways.empty();
    const auto poses = wander(
        walk, rounded ? rolled_path(walk, runs[i], timing, random.child("counts").child(i)) : mean,
        random.child("walk").child(i), options.noise);
    const PoseSigmas sigma = pose_sigmas(noise, of_set, runs[i], mean);
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
