#include "app/logs/log_signals.h"

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <unordered_map>

#include "app/logs/joint_names.h"
#include "app/logs/replay_match.h"
#include "scheduler/log/printed_line.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::app {
namespace {

using scheduler::Answer;
using scheduler::Topic;

// A client may make up names for ever.
constexpr size_t kMostNames = 10'000;
// Events that every match may have: that none came is an answer.
constexpr const char* kEventNames[] = {"goal", "kick", "grab", "ball_touched"};
constexpr const char* kOwnEvents[] = {"printed", "decision", "frame"};

std::string plain(std::string name) {
  for (char& c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (!letter && !(c >= '0' && c <= '9') && c != '_' && c != '.') c = '_';
  }
  return name;
}

// Which of the names are wanted, and all names that there are.
class NameTable {
 public:
  static constexpr int kNobody = -1;

  explicit NameTable(const std::vector<std::string>& wanted) {
    for (size_t i = 0; i < wanted.size(); ++i) wanted_.emplace(wanted[i], static_cast<int>(i));
  }
  // The place of a name among those wanted, or kNobody.
  int add(const std::string& name) {
    if (known_.size() < kMostNames) known_.insert(name);
    const auto found = wanted_.find(name);
    return found == wanted_.end() ? kNobody : found->second;
  }
  // A family of names: whether one of them is wanted.
  bool wants(const std::function<bool(const std::string&)>& is_one) const {
    return std::ranges::any_of(wanted_, [&](const auto& one) { return is_one(one.first); });
  }
  bool knows(const std::string& name) const { return known_.contains(name); }
  std::vector<std::string> all() const { return {known_.begin(), known_.end()}; }

 private:
  std::unordered_map<std::string, int> wanted_;
  std::set<std::string> known_;
};

// The nearest known name, where one is near: a log has too many to list all.
std::string near(const std::string& unknown, const std::vector<std::string>& known) {
  const std::string suggestion = suggestion_for(unknown, known);
  return suggestion.find("did you mean") == suggestion.npos ? "" : suggestion;
}

// Goes once through a log's records.
class SignalReader {
 public:
  SignalReader(const scheduler::Log& log, const std::vector<std::string>& wanted, bool every_name)
      : log_(log), names_(wanted), joints_(log.header()), every_name_(every_name) {
    for (const std::string& robot : log.header().robots) robots_.push_back({plain(robot)});
    add_fixed_names();
  }

  void read() {
    scheduler::TopicSet topics = {Topic::turn, Topic::event};
    if (every_name_ || wants_part("truth.")) topics.insert(Topic::step);
    if (wants_part(".event.frame")) topics.insert(Topic::frame);
    scheduler::LogCursor cursor(log_, topics);
    while (const auto record = cursor.next()) std::visit(*this, *record);
    if (wants_part(".printed")) read_printed();
    if (every_name_ || wants_joints()) read_joints();
    std::ranges::stable_sort(samples_, {}, &SignalSample::time);
  }

  void operator()(const scheduler::RunHeader&) {}
  void operator()(const scheduler::SnapshotRecord&) {}
  void operator()(const scheduler::EndRecord&) {}
  void operator()(const scheduler::SimulationEvent& event) {
    give(event_slot("event." + event.name), event.time, 1);
    if (!event.robot.empty()) give(event_slot(event.robot + ".event." + event.name), event.time, 1);
  }
  void operator()(const scheduler::FrameRecord& frame) {
    give(own_event(frame.robot, "frame"), frame.time, 1);
  }
  void operator()(const scheduler::TurnRecord& turn) {
    for (const Answer& answer : turn.turn.answers) {
      if (static_cast<size_t>(answer.robot) < robots_.size()) take(turn.time, answer);
    }
  }
  void operator()(const scheduler::StepRecord& step) {
    constexpr size_t kFields = std::size(scheduler::kPoseFields);
    if (step.poses.size() != kFields * robots_.size() + 3) return;
    pose_times_.push_back(step.time);
    const float* const ball = step.poses.data() + kFields * robots_.size();
    for (size_t i = 0; i < robots_.size(); ++i) {
      const float* const pose = step.poses.data() + kFields * i;
      const std::vector<int>& slots = robots_[i].truth;
      for (size_t field = 0; field + 1 < slots.size(); ++field)
        give(slots[field], step.time, static_cast<double>(pose[field]));
      give(slots.back(), step.time,
           maths::length(static_cast<double>(ball[0]) - static_cast<double>(pose[0]),
                         static_cast<double>(ball[1]) - static_cast<double>(pose[1])));
    }
    for (size_t axis = 0; axis < 3; ++axis)
      give(ball_[axis], step.time, static_cast<double>(ball[axis]));
  }

  NameTable& names() { return names_; }
  std::vector<SignalSample> take_samples() { return std::move(samples_); }

 private:
  struct OfRobot {
    std::string id;
    std::vector<int> truth;  // By pose field, then the ball's distance.
    std::unordered_map<std::string, int> logged;
    std::map<std::pair<int, std::string>, int> commands;  // By joint, or -1 and the name.
  };

  bool wants_part(std::string_view part) const {
    return names_.wants([&](const std::string& name) { return name.find(part) != name.npos; });
  }
  void give(int slot, SimTime time, double value) {
    if (slot != NameTable::kNobody) samples_.push_back({time, static_cast<uint32_t>(slot), value});
  }

  void add_fixed_names() {
    names_.add("time_s");
    for (size_t i = 0; i < robots_.size(); ++i) {
      const std::string truth = "truth." + robots_[i].id + ".";
      const size_t fields = joints_.lacks_head(i) ? 3 : std::size(scheduler::kPoseFields);
      for (size_t field = 0; field < fields; ++field)
        robots_[i].truth.push_back(names_.add(truth + std::string(scheduler::kPoseFields[field])));
      robots_[i].truth.push_back(names_.add(truth + "ball_distance_m"));
      for (const char* name : kOwnEvents) names_.add(robots_[i].id + ".event." + name);
      for (const char* name : kEventNames) names_.add(robots_[i].id + ".event." + name);
    }
    for (const char* axis : {"x_m", "y_m", "z_m"})
      ball_.push_back(names_.add(std::string("truth.ball.") + axis));
    for (const char* name : kEventNames) names_.add(std::string("event.") + name);
  }

  int event_slot(const std::string& name) { return names_.add(plain(name)); }
  int own_event(int robot, const char* name) {
    if (static_cast<size_t>(robot) >= robots_.size()) return NameTable::kNobody;
    return names_.add(robots_[static_cast<size_t>(robot)].id + ".event." + name);
  }

  int command_slot(OfRobot& robot, int number, int joint, const char* name) {
    const auto [found, is_new] = robot.commands.try_emplace({joint, name}, NameTable::kNobody);
    if (is_new) {
      const std::string what =
          joint < 0 ? name : joints_.of(static_cast<size_t>(number), joint) + "_rad";
      found->second = names_.add(plain(robot.id + ".command." + what));
    }
    return found->second;
  }

  void take(SimTime time, const Answer& answer) {
    OfRobot& robot = robots_[static_cast<size_t>(answer.robot)];
    give(own_event(answer.robot, "decision"), time, 1);
    const RobotCommand& command = answer.decision.command;
    if (command.walk) {
      const BodyVelocity& walk = *command.walk;
      give(command_slot(robot, answer.robot, -1, "vx_m_s"), time, walk.vx_mps);
      give(command_slot(robot, answer.robot, -1, "vy_m_s"), time, walk.vy_mps);
      give(command_slot(robot, answer.robot, -1, "omega_rad_s"), time, walk.omega_radps);
    }
    for (const JointFrame& frame : command.joints) {
      for (const JointTarget& target : frame.targets)
        give(command_slot(robot, answer.robot, target.joint, ""), time + frame.offset,
             target.angle_rad);
    }
    for (const scheduler::DebugItem& item : answer.decision.debug) {
      if (item.kind != scheduler::DebugItem::Kind::value) continue;
      auto found = robot.logged.find(item.name);
      if (found == robot.logged.end()) {
        if (robot.logged.size() == kMostNames) continue;
        const int slot = names_.add(plain(robot.id + "." + item.name));
        found = robot.logged.emplace(item.name, slot).first;
      }
      give(found->second, time, item.value);
    }
  }

  void read_printed() {
    scheduler::PrintedCursor lines(log_);
    while (const auto line = lines.next())
      give(names_.add(plain(line->robot + ".event.printed")), line->time, 1);
  }

  // Joints without a place in the log's poses are known to its world alone.
  bool wants_joints() const {
    return names_.wants([&](const std::string& name) {
      return name.starts_with("truth.") && name.ends_with("_rad") && !names_.knows(name);
    });
  }
  void read_joints() {
    ReplayMatch match(log_);
    const std::vector<RobotSpec>& specs = match.scenario().robots;
    std::vector<std::vector<int>> slots(specs.size());
    bool any = false;
    for (size_t i = 0; i < specs.size() && i < robots_.size(); ++i) {
      for (size_t joint = 0; joint < specs[i].body.joint_count(); ++joint) {
        slots[i].push_back(names_.add(
            plain("truth." + robots_[i].id + "." + specs[i].body.joint_name(joint) + "_rad")));
        any |= slots[i].back() != NameTable::kNobody;
      }
    }
    if (!any) return;
    for (const SimTime pose_time : pose_times_) {
      const SimTime time = match.rewinder().to(pose_time);
      for (size_t i = 0; i < slots.size(); ++i) {
        const JointAngles angles_rad = match.world().robot(i, time).joints_rad;
        for (size_t joint = 0; joint < slots[i].size(); ++joint)
          give(slots[i][joint], time, angles_rad[joint]);
      }
    }
  }

  const scheduler::Log& log_;
  NameTable names_;
  const JointNames joints_;
  const bool every_name_;
  std::vector<OfRobot> robots_;
  std::vector<int> ball_;
  std::vector<SimTime> pose_times_;
  std::vector<SignalSample> samples_;
};

}  // namespace

LogSignals read_signals(const scheduler::Log& log, const std::vector<std::string>& names) {
  SignalReader reader(log, names, false);
  reader.read();
  LogSignals signals{reader.take_samples(), std::vector<bool>(names.size(), false), log.end_time()};
  for (size_t i = 0; i < names.size(); ++i) {
    if (!reader.names().knows(names[i])) {
      throw UsageError(
          fmt::format("condition: the log has no '{}'{} (`seam replay find {} --names` "
                      "lists all names)",
                      names[i], near(names[i], reader.names().all()), log.name()));
    }
    signals.instant[i] =
        names[i].starts_with("event.") || names[i].find(".event.") != names[i].npos;
  }
  return signals;
}

std::vector<std::string> signal_names(const scheduler::Log& log) {
  SignalReader reader(log, {}, true);
  reader.read();
  return reader.names().all();
}

}  // namespace seam::app
