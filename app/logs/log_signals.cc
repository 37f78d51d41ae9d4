#include "app/logs/log_signals.h"

#include <algorithm>
#include <memory>

#include "app/logs/joint_names.h"
#include "app/logs/replay_match.h"
#include "app/signals/record_signals.h"
#include "scheduler/log/printed_line.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using scheduler::Topic;

std::vector<SignalRobot> robots_of(const scheduler::RunHeader& header) {
  const auto joints = std::make_shared<const JointNames>(header);
  std::vector<SignalRobot> robots;
  for (size_t i = 0; i < header.robots.size(); ++i)
    robots.push_back({header.robots[i], !joints->lacks_head(i),
                      [joints, i](int joint) { return joints->of(i, joint); }});
  return robots;
}

// Goes once through a log's records.
class SignalReader {
 public:
  SignalReader(const scheduler::Log& log, const std::vector<std::string>& wanted, bool every_name)
      : log_(log),
        signals_(robots_of(log.header()), wanted,
                 [this](int name, SimTime time, double value) {
                   samples_.push_back({time, static_cast<uint32_t>(name), value});
                 }),
        every_name_(every_name) {}

  void read() {
    scheduler::TopicSet topics = {Topic::turn, Topic::event};
    if (every_name_ || names().wants_part("truth.")) topics.insert(Topic::step);
    if (names().wants_part(".event.frame")) topics.insert(Topic::frame);
    scheduler::LogCursor cursor(log_, topics);
    while (const auto record = cursor.next()) std::visit(*this, *record);
    if (names().wants_part(".printed")) read_printed();
    if (every_name_ || wants_joints()) read_joints();
    std::ranges::stable_sort(samples_, {}, &SignalSample::time);
  }

  void operator()(const scheduler::RunHeader&) {}
  void operator()(const scheduler::SnapshotRecord&) {}
  void operator()(const scheduler::EndRecord&) {}
  void operator()(const scheduler::SimulationEvent& event) { signals_.take_event(event); }
  void operator()(const scheduler::FrameRecord& frame) {
    signals_.take_frame(frame.robot, frame.time);
  }
  void operator()(const scheduler::TurnRecord& turn) { signals_.take_turn(turn.time, turn.turn); }
  void operator()(const scheduler::StepRecord& step) {
    if (step.poses.empty()) return;
    pose_times_.push_back(step.time);
    signals_.take_poses(step.time, std::vector<double>(step.poses.begin(), step.poses.end()));
  }

  SignalNames& names() { return signals_.names(); }
  std::vector<SignalSample> take_samples() { return std::move(samples_); }

 private:
  void read_printed() {
    scheduler::PrintedCursor lines(log_);
    while (const auto line = lines.next()) signals_.take_printed(line->robot, line->time);
  }

  // Joints without a place in the log's poses are known to its world alone.
  bool wants_joints() {
    return names().wants([&](const std::string& name) {
      return name.starts_with("truth.") && name.ends_with("_rad") && !names().knows(name);
    });
  }
  void read_joints() {
    ReplayMatch match(log_);
    const std::vector<RobotSpec>& specs = match.scenario().robots;
    std::vector<std::vector<int>> slots(specs.size());
    bool any = false;
    for (size_t i = 0; i < specs.size() && i < signals_.robots(); ++i) {
      for (size_t joint = 0; joint < specs[i].body.joint_count(); ++joint) {
        slots[i].push_back(signals_.add_joint(i, specs[i].body.joint_name(joint)));
        any |= slots[i].back() != SignalNames::kNobody;
      }
    }
    if (!any) return;
    for (const SimTime pose_time : pose_times_) {
      const SimTime time = match.rewinder().to(pose_time);
      for (size_t i = 0; i < slots.size(); ++i) {
        const JointAngles angles_rad = match.world().robot(i, time).joints_rad;
        for (size_t joint = 0; joint < slots[i].size(); ++joint)
          signals_.give(slots[i][joint], time, angles_rad[joint]);
      }
    }
  }

  const scheduler::Log& log_;
  std::vector<SignalSample> samples_;
  RecordSignals signals_;
  const bool every_name_;
  std::vector<SimTime> pose_times_;
};

}  // namespace

LogSignals read_signals(const scheduler::Log& log, const std::vector<std::string>& names) {
  SignalReader reader(log, names, false);
  reader.read();
  for (const std::string& name : names) {
    if (!reader.names().knows(name)) {
      throw UsageError(
          fmt::format("condition: the log has no '{}'{} (`seam replay find {} --names` "
                      "lists all names)",
                      name, reader.names().near(name), log.name()));
    }
  }
  return {reader.take_samples(), log.end_time()};
}

std::vector<std::string> signal_names(const scheduler::Log& log) {
  SignalReader reader(log, {}, true);
  reader.read();
  return reader.names().all();
}

}  // namespace seam::app
