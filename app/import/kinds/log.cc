// `seam import log`: the head's joints, the walk or the frames of a robot in a replay log of ours.
#include "scheduler/log/log.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "app/import/draft/walk_draft.h"
#include "app/import/kinds/kinds.h"
#include "app/import/kinds/log_frames.h"
#include "app/logs/replay_match.h"
#include "sim_core/base/error.h"
#include "sim_core/scenario/scenario.h"

namespace seam::app {
namespace {

// The commands of one robot, and what became of them.
class RobotLog {
 public:
  RobotLog(const scheduler::Log& log, const Scenario& scenario, size_t robot)
      : log_(log), robot_(robot), body_(scenario.robots[robot].body), step_(scenario.step) {
    const SimDuration latency = scenario.robots[robot].behaviour.decision_latency;
    latency_ = latency == SimDuration() ? step_ : latency;
  }

  void read() {
    scheduler::LogCursor cursor(log_, {scheduler::Topic::turn});
    while (const auto record = cursor.next()) {
      if (const auto* turn = std::get_if<scheduler::TurnRecord>(&*record)) take(*turn);
    }
    // Logs keep poses of few steps: the match runs again for those of each.
    ReplayMatch match(log_);
    const SimTime end = log_.end_time();
    for (SimTime time; time <= end; time = time + step_) {
      if (match.rewinder().to(time) != time) break;
      const RobotTruth truth = match.world().robot(robot_, time);
      times_.push_back(time.ns());
      poses_.push_back({time.ns(), truth.pose.x_m, truth.pose.y_m, truth.pose.theta_rad});
      joints_rad_.push_back(truth.joints_rad);
    }
    if (times_.size() < 2)
      throw InputError(fmt::format("{}: ends before its second step", log_.name()));
  }

  size_t joint_commands() const {
    size_t count = 0;
    for (const auto& targets : targets_) count += targets.size();
    return count;
  }
  void draft_joints(SetDraft& draft) const;
  void draft_walks(SetDraft& draft) const;

 private:
  void take(const scheduler::TurnRecord& turn) {
    for (const scheduler::Answer& answer : turn.turn.answers) {
      if (answer.robot != static_cast<int>(robot_)) continue;
      const SimTime acts = turn.time + latency_;
      const RobotCommand& command = answer.decision.command;
      if (command.walk)
        walk_.push_back(
            {acts.ns(), command.walk->vx_mps, command.walk->vy_mps, command.walk->omega_radps});
      for (const JointFrame& frame : command.joints) {
        for (const JointTarget& target : frame.targets) {
          // Legs follow the gait; what else moves has commands of its own.
          if (!body_.is_leg(target.joint))
            targets_[static_cast<size_t>(target.joint)][(acts + frame.offset).ns()] =
                target.angle_rad;
        }
      }
    }
  }

  const scheduler::Log& log_;
  size_t robot_;
  const RobotBody body_;
  SimDuration step_, latency_;
  std::vector<int64_t> times_;
  std::vector<PlanarPose> poses_;
  std::vector<JointAngles> joints_rad_;
  std::array<std::map<int64_t, double>, kMostJoints> targets_;  // By the time they act.
  std::vector<VelocityCommand> walk_;
};

void RobotLog::draft_joints(SetDraft& draft) const {
  measurement::CsvWriter table({"run", "time_s", "joint", "command_rad", "measured_rad"});
  std::vector<std::string> moved;
  size_t rows = 0;
  for (size_t joint = 0; joint < body_.joint_count(); ++joint) {
    const auto& targets = targets_[joint];
    if (targets.empty()) continue;
    const std::string name = body_.joint_name(joint);
    moved.push_back(name);
    auto next = targets.begin();
    // Until the first command the joint holds what it has.
    double command = joints_rad_.front()[joint];
    for (size_t i = 0; i < times_.size(); ++i) {
      for (; next != targets.end() && next->first <= times_[i]; ++next) command = next->second;
      table.row(
          {name, seconds_text(times_[i]), name, exact(command), exact(joints_rad_[i][joint])});
      ++rows;
    }
  }
  if (moved.empty())
    throw InputError(fmt::format("{}: no joint of {} but legs was commanded", log_.name(),
                                 log_.header().robots[robot_]));
  draft.kind = "joints";
  draft.group = "run";
  draft.effects = "  ideal_servo: {}\n";
  draft.add_table("joints", table);
  draft.did(
      fmt::format("{} rows of {}, true angles of the match run again, at each step under the "
                  "targets that act then",
                  rows, fmt::join(moved, ", ")));
  draft.could_not_know(
      "the speeds that targets asked for: a set has angles alone, so they show as a limit of "
      "speed");
}

void RobotLog::draft_walks(SetDraft& draft) const {
  std::vector<VelocityCommand> commands = walk_;
  if (commands.empty())
    throw InputError(
        fmt::format("{}: {} has no command to walk", log_.name(), log_.header().robots[robot_]));
  std::stable_sort(commands.begin(), commands.end(),
                   [](const VelocityCommand& a, const VelocityCommand& b) { return a.ns < b.ns; });
  commands.push_back(commands.back());
  commands.back().ns = std::max(commands.back().ns, poses_.back().ns);
  draft_walk(commands, poses_, draft);
}

}  // namespace

void import_log(const ImportRequest& request, SetDraft& draft) {
  if (request.sources.size() != 1) throw UsageError("log: expected one replay log");
  const auto log = scheduler::Log::open(request.sources[0]);
  const auto scenario = Scenario::from_text(log.header().scenario_text, log.header().scenario_name);
  const auto& robots = log.header().robots;
  const std::string wanted = request.camera.empty() && !robots.empty() ? robots[0] : request.camera;
  const auto found = std::find(robots.begin(), robots.end(), wanted);
  if (found == robots.end() || scenario.robots.size() != robots.size())
    throw InputError(fmt::format("{}: --camera {}: no such robot{}", log.name(), wanted,
                                 suggestion_for(wanted, robots)));
  const auto place = static_cast<size_t>(found - robots.begin());
  draft.did(fmt::format("robot {} of scenario {} (--camera, --part joints, odometry or frames)",
                        wanted, log.header().scenario_name));
  if (request.part == "frames") return draft_frames(log, place, draft);
  RobotLog robot(log, scenario, place);
  robot.read();
  if (request.part.empty() ? robot.joint_commands() > 0 : request.part == "joints") {
    robot.draft_joints(draft);
  } else {
    robot.draft_walks(draft);
  }
}

}  // namespace seam::app
