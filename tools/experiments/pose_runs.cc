#include "tools/experiments/pose_runs.h"

#include <fmt/format.h>

#include <cmath>

#include "app/data_file.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"
#include "sim_core/base/random.h"

namespace seam::tools {
namespace {

std::string run_name(const std::string& mode_name, const Pose2& pose, int seed) {
  return fmt::format("{}_x{:.0f}_y{:.0f}_t{:.0f}_s{}", mode_name, 1e3 * pose.x_m, 1e3 * pose.y_m,
                     pose.theta_rad * 180 / maths::kPi, seed);
}

void set_clock(CameraSpec& camera, const PoseMode& mode, RandomStream phases) {
  const int frames = mode.frames_per_swing > 0 ? mode.frames_per_swing : nearest_frames_per_swing();
  const double period_s = mode.frames_per_swing > 0 ? kSwingPeriod_s / frames : kFramePeriod_s;
  // Where in the swing the first frame falls is left to chance in both modes, with the same chance.
  const double phase = mode.phase < 0 ? uniform(phases, 0) : mode.phase;
  camera.locked = mode.locked;
  camera.lock_cycle = SimDuration::from_s(kSwingPeriod_s);
  camera.lock_frames = frames;
  camera.lock_start = SimDuration::from_s(phase * kSwingPeriod_s / frames);
  const double slipped = mode.frames_per_swing > 0 ? frames / (frames + mode.slip) : 1;
  camera.clock.period = SimDuration::from_s(period_s * slipped);
  camera.clock.phase = SimDuration::from_s(phase * period_s);
}

Pose2 at_end(const LoggedValues& values, const std::string& prefix) {
  return {values.at(prefix + "x_m").back().value, values.at(prefix + "y_m").back().value,
          values.at(prefix + "theta_rad").back().value};
}

}  // namespace

int nearest_frames_per_swing() {
  return static_cast<int>(std::lround(kSwingPeriod_s / kFramePeriod_s));
}

std::vector<Pose2> paper_poses(int count) {
  std::vector<Pose2> poses;
  for (double heading_deg : {45.0, -135.0, -45.0, 135.0}) {
    for (double x_m : {0.0, 1.0, 1.75}) {
      for (double y_m : {0.0, 0.5, 1.0})
        poses.push_back({x_m, y_m, heading_deg * maths::kPi / 180});
    }
  }
  if (count >= static_cast<int>(poses.size())) return poses;
  std::vector<Pose2> some;
  for (int i = 0; i < count; ++i) some.push_back(poses[(i * 10 + i) % poses.size()]);
  return some;
}

PlannedRun pose_run(const std::string& mode_name, const PoseMode& mode, const Pose2& pose,
                    int seed) {
  static const Scenario base = Scenario::from_file(app::data_file("scenarios/localization.yaml"));
  PlannedRun run{run_name(mode_name, pose, seed), base};
  run.scenario.seed = seed;
  run.scenario.duration = SimDuration::from_s(mode.duration_s);
  RobotSpec& robot = run.scenario.robots.front();
  robot.pose = pose;
  if (!mode.model_yaml.empty()) robot.camera.model_yaml = mode.model_yaml;
  set_clock(robot.camera, mode,
            RandomStream{static_cast<uint64_t>(seed), 0}.child(run_name("", pose, 0)));
  robot.behaviour.command = {"localizer",
                             "--seed",
                             std::to_string(seed),
                             "--swing-period-s",
                             fmt::format("{}", kSwingPeriod_s),
                             "--amplitude",
                             fmt::format("{}", kSwingAmplitude_rad),
                             "--particles",
                             std::to_string(mode.particles),
                             "--sensor-width",
                             fmt::format("{}", mode.sensor_width),
                             "--row-times",
                             mode.row_times ? "1" : "0"};
  if (!mode.use_ranges)
    robot.behaviour.command.insert(robot.behaviour.command.end(), {"--ranges", "0"});
  return run;
}

PoseResult read_pose_run(const std::filesystem::path& folder, const std::string& mode_name,
                         const Pose2& pose, int seed) {
  const std::string name = run_name(mode_name, pose, seed);
  return pose_result(logged_values(folder / (name + ".mcap")), name, pose);
}

PoseResult pose_result(const LoggedValues& values, const std::string& run, const Pose2& pose) {
  if (!values.contains("x_m"))
    throw InputError(fmt::format("run {}: the localizer logged no estimate", run));
  PoseResult result{.truth = pose,
                    .mean = at_end(values, ""),
                    .low = at_end(values, "low."),
                    .high = at_end(values, "high.")};
  const auto& xs = values.at("x_m");
  const auto& ys = values.at("y_m");
  const auto& thetas = values.at("theta_rad");
  const size_t half = xs.size() / 2;
  double x = 0, y = 0, turn = 0, square = 0;
  const double n = static_cast<double>(xs.size() - half);
  for (size_t i = half; i < xs.size(); ++i) {
    x += xs[i].value / n, y += ys[i].value / n;
    turn += maths::wrap_angle(thetas[i].value - pose.theta_rad) / n;
  }
  for (size_t i = half; i < xs.size(); ++i) {
    square += ((xs[i].value - x) * (xs[i].value - x) + (ys[i].value - y) * (ys[i].value - y)) / n;
  }
  result.settled = {x, y, pose.theta_rad + turn};
  result.settled_spread_m = std::sqrt(square);
  return result;
}

}  // namespace seam::tools
