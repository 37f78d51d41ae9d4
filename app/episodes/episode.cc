#include "app/episodes/episode.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "app/logs/open_loop.h"
#include "app/logs/replay_match.h"
#include "scheduler/loop/simulation.h"
#include "scheduler/replay/player.h"
#include "sim_core/base/error.h"
#include "sim_core/body/joint_table.h"

namespace seam::app {

namespace {

constexpr size_t kWalk = 3;                          // vx, vy, omega.
constexpr size_t kMostPixelBytes = size_t{2} << 30;  // In memory, until they are written.

EpisodeKind kind_of(const RobotSpec& robot, bool with_frames) {
  EpisodeKind kind{.robot = robot.id,
                   .robot_type = robot.body.name,
                   .turns_per_s = 1 / robot.behaviour.clock.period.s()};
  const std::vector<std::string> joints = joint_field_names(robot.body);
  for (size_t joint = 0; joint < joints.size(); ++joint) {
    const EpisodeField field{"joints." + joints[joint], joint_unit(robot.body, joint)};
    kind.state.push_back(field);
    kind.action.push_back(field);
  }
  kind.state.insert(kind.state.end(), {{"odometry.x_m", "m"},
                                       {"odometry.y_m", "m"},
                                       {"odometry.heading_rad", "rad"},
                                       {"acceleration.x_m_s2", "m/s^2"},
                                       {"acceleration.y_m_s2", "m/s^2"},
                                       {"acceleration.z_m_s2", "m/s^2"}});
  if (robot.sensors.gyroscope)
    kind.state.insert(kind.state.end(), {{"angular_velocity.x_rad_s", "rad/s"},
                                         {"angular_velocity.y_rad_s", "rad/s"},
                                         {"angular_velocity.z_rad_s", "rad/s"}});
  kind.action.insert(kind.action.end(), {{"walk.vx_m_s", "m/s"},
                                         {"walk.vy_m_s", "m/s"},
                                         {"walk.omega_rad_s", "rad/s"},
                                         {"kick", "number of the kick, 0 none"}});
  if (!with_frames) return kind;
  kind.height_px = static_cast<size_t>(robot.camera.height_px);
  kind.width_px = static_cast<size_t>(robot.camera.width_px);
  return kind;
}

// Fills an episode while the log is run again.
class Watcher final : public scheduler::SimulationObserver {
 public:
  Watcher(Episode& episode, int robot, size_t joints)
      : episode_(episode), robot_(robot), joints_(joints), walk_(kWalk, 0) {}

  void on_observation(const scheduler::Observation& seen) override {
    if (seen.robot != robot_) return;
    episode_.time_ns.push_back(seen.time.ns());
    const RobotSensors& sensors = seen.sensors;
    auto& state = episode_.state;
    state.insert(state.end(), sensors.joints.rad.begin(), sensors.joints.rad.begin() + joints_);
    const Vec3& a = sensors.acceleration_m_s2;
    for (const double value :
         {sensors.odometry.x_m, sensors.odometry.y_m, sensors.odometry.theta_rad, a.x, a.y, a.z})
      state.push_back(value);
    if (const auto& rate = sensors.angular_velocity_rad_s)
      state.insert(state.end(), {rate->x, rate->y, rate->z});
    // Before the first order a joint is asked to stay where it is.
    if (targets_.empty())
      targets_.assign(sensors.joints.rad.begin(), sensors.joints.rad.begin() + joints_);
    if (episode_.kind.height_px == 0) return;
    if (!seen.frames.empty()) newest_ = seen.frames.back();
    episode_.frame_index.push_back(newest_ ? static_cast<int64_t>(newest_->frame_index) : -1);
    const size_t pixels = episode_.kind.height_px * episode_.kind.width_px * 3;
    auto& rgb = episode_.rgb;
    if (rgb.size() + pixels > kMostPixelBytes)
      throw InputError(
          fmt::format("frames of more than {} MB in one episode: record shorter runs, or "
                      "leave --frames out",
                      kMostPixelBytes >> 20));
    if (newest_ && newest_->rgb.size() == pixels)
      rgb.insert(rgb.end(), newest_->rgb.begin(), newest_->rgb.end());
    else
      rgb.resize(rgb.size() + pixels);
  }

  // The orders that hold from then on: a target and a walk stay until there are others.
  void on_turn(SimTime, const scheduler::Turn& turn) override {
    for (const scheduler::Answer& answer : turn.answers) {
      if (answer.robot != robot_) continue;
      if (answer.outcome == scheduler::Outcome::frozen) std::ranges::fill(walk_, 0);
      const RobotCommand& command = answer.decision.command;
      for (const JointFrame& frame : command.joints) {
        for (const JointTarget& target : frame.targets)
          if (static_cast<size_t>(target.joint) < joints_)
            targets_[static_cast<size_t>(target.joint)] = target.angle_rad;
      }
      if (command.walk)
        walk_ = {command.walk->vx_mps, command.walk->vy_mps, command.walk->omega_radps};
      auto& action = episode_.action;
      action.insert(action.end(), targets_.begin(), targets_.end());
      action.insert(action.end(), walk_.begin(), walk_.end());
      action.push_back(static_cast<double>(command.kick));
    }
  }

 private:
  Episode& episode_;
  const int robot_;
  const size_t joints_;
  std::vector<double> targets_, walk_;
  std::shared_ptr<const Frame> newest_;
};

std::string only_robot(const Scenario& scenario) {
  if (scenario.robots.size() == 1) return scenario.robots[0].id;
  std::vector<std::string> names;
  for (const RobotSpec& robot : scenario.robots) names.push_back(robot.id);
  throw UsageError(
      fmt::format("expected --robot with a robot of the log: {}", fmt::join(names, ", ")));
}

}  // namespace

Episode episode_of(const scheduler::Log& log, const std::string& robot, bool with_frames) {
  ReplayMatch match(log);
  const std::string name = robot.empty() ? only_robot(match.scenario()) : robot;
  const int number = match.robot(name);
  const RobotSpec& spec = match.scenario().robots[static_cast<size_t>(number)];
  Episode episode{.kind = kind_of(spec, with_frames),
                  .seed = static_cast<int64_t>(match.scenario().seed)};
  Watcher watcher(episode, number, spec.body.joint_count());
  scheduler::LogSource decisions(log);
  scheduler::RunControl control;
  std::optional<OneRobotsFrames> frames;
  if (with_frames) frames.emplace(log, match.renderer(), number);
  scheduler::Simulation({match.scenario(),
                         match.world(),
                         decisions,
                         control,
                         frames ? &*frames : nullptr,
                         {&watcher},
                         match.header()},
                        {.state_hashes = false})
      .run();
  // A log that was cut has an observation without its decision.
  const size_t rows = episode.action.size() / episode.kind.action.size();
  if (rows == 0)
    throw InputError(fmt::format(
        "{}: robot '{}' decided nothing, expected a run with its decisions", log.name(), name));
  episode.time_ns.resize(rows);
  episode.state.resize(rows * episode.kind.state.size());
  if (with_frames) {
    episode.frame_index.resize(rows);
    episode.rgb.resize(rows * episode.kind.height_px * episode.kind.width_px * 3);
  }
  return episode;
}

}  // namespace seam::app
