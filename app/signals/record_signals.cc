#include "app/signals/record_signals.h"

#include <algorithm>
#include <utility>

#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::app {
namespace {

using scheduler::Answer;

// A client may make up names for ever.
constexpr size_t kMostNames = 10'000;
// Events that every match may have: that none came is an answer.
constexpr const char* kEventNames[] = {"goal", "kick", "grab", "ball_touched"};
constexpr const char* kOwnEvents[] = {"printed", "decision", "frame"};

}  // namespace

std::string plain_name(std::string name) {
  for (char& c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (!letter && !(c >= '0' && c <= '9') && c != '_' && c != '.') c = '_';
  }
  return name;
}

bool is_event(const std::string& name) {
  return name.starts_with("event.") || name.find(".event.") != name.npos;
}

SignalNames::SignalNames(const std::vector<std::string>& wanted) {
  for (size_t i = 0; i < wanted.size(); ++i) wanted_.emplace(wanted[i], static_cast<int>(i));
}

int SignalNames::add(const std::string& name) {
  if (known_.size() < kMostNames) known_.insert(name);
  const auto found = wanted_.find(name);
  return found == wanted_.end() ? kNobody : found->second;
}

bool SignalNames::wants(const std::function<bool(const std::string&)>& is_one) const {
  return std::ranges::any_of(wanted_, [&](const auto& one) { return is_one(one.first); });
}

bool SignalNames::wants_part(std::string_view part) const {
  return wants([&](const std::string& name) { return name.find(part) != name.npos; });
}

std::string SignalNames::near(const std::string& unknown) const {
  const std::string suggestion = suggestion_for(unknown, all());
  return suggestion.find("did you mean") == suggestion.npos ? "" : suggestion;
}

RecordSignals::RecordSignals(const std::vector<SignalRobot>& robots,
                             const std::vector<std::string>& wanted, Give give)
    : names_(wanted), give_(std::move(give)) {
  for (const SignalRobot& robot : robots)
    robots_.push_back({plain_name(robot.id), robot.joint_name, {}, {}, {}});
  add_fixed_names(robots);
}

void RecordSignals::add_fixed_names(const std::vector<SignalRobot>& robots) {
  names_.add("time_s");
  for (size_t i = 0; i < robots_.size(); ++i) {
    const std::string truth = "truth." + robots_[i].id + ".";
    const size_t fields = robots[i].has_head ? std::size(scheduler::kPoseFields) : 3;
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

void RecordSignals::give(int name, SimTime time, double value) const {
  if (name != SignalNames::kNobody) give_(name, time, value);
}

void RecordSignals::take_event(const scheduler::SimulationEvent& event) {
  give(names_.add(plain_name("event." + event.name)), event.time, 1);
  if (!event.robot.empty())
    give(names_.add(plain_name(event.robot + ".event." + event.name)), event.time, 1);
}

void RecordSignals::take_frame(int robot, SimTime time) {
  give(own_event(robot, "frame"), time, 1);
}

void RecordSignals::take_printed(const std::string& robot, SimTime time) {
  give(names_.add(plain_name(robot + ".event.printed")), time, 1);
}

void RecordSignals::take_turn(SimTime time, const scheduler::Turn& turn) {
  for (const Answer& answer : turn.answers)
    if (static_cast<size_t>(answer.robot) < robots_.size()) take_answer(time, answer);
}

void RecordSignals::take_poses(SimTime time, std::span<const double> poses) {
  constexpr size_t kFields = std::size(scheduler::kPoseFields);
  if (poses.size() != kFields * robots_.size() + 3) return;
  const std::span<const double> ball = poses.subspan(kFields * robots_.size());
  for (size_t i = 0; i < robots_.size(); ++i) {
    const std::span<const double> pose = poses.subspan(kFields * i, kFields);
    const std::vector<int>& truth = robots_[i].truth;
    for (size_t field = 0; field + 1 < truth.size(); ++field) give(truth[field], time, pose[field]);
    give(truth.back(), time, maths::length(ball[0] - pose[0], ball[1] - pose[1]));
  }
  for (size_t axis = 0; axis < 3; ++axis) give(ball_[axis], time, ball[axis]);
}

int RecordSignals::add_joint(size_t robot, const std::string& joint) {
  return names_.add(plain_name("truth." + robots_[robot].id + "." + joint + "_rad"));
}

int RecordSignals::own_event(int robot, const char* name) {
  if (static_cast<size_t>(robot) >= robots_.size()) return SignalNames::kNobody;
  return names_.add(robots_[static_cast<size_t>(robot)].id + ".event." + name);
}

int RecordSignals::command_name(OfRobot& robot, int joint, const char* name) {
  const auto [found, is_new] = robot.commands.try_emplace({joint, name}, SignalNames::kNobody);
  if (is_new) {
    const std::string what = joint < 0 ? name : robot.joint_name(joint) + "_rad";
    found->second = names_.add(plain_name(robot.id + ".command." + what));
  }
  return found->second;
}

void RecordSignals::take_answer(SimTime time, const Answer& answer) {
  OfRobot& robot = robots_[static_cast<size_t>(answer.robot)];
  give(own_event(answer.robot, "decision"), time, 1);
  const RobotCommand& command = answer.decision.command;
  if (command.walk) {
    const BodyVelocity& walk = *command.walk;
    give(command_name(robot, -1, "vx_m_s"), time, walk.vx_mps);
    give(command_name(robot, -1, "vy_m_s"), time, walk.vy_mps);
    give(command_name(robot, -1, "omega_rad_s"), time, walk.omega_radps);
  }
  for (const JointFrame& frame : command.joints) {
    for (const JointTarget& target : frame.targets)
      give(command_name(robot, target.joint, ""), time + frame.offset, target.angle_rad);
  }
  for (const scheduler::DebugItem& item : answer.decision.debug) {
    if (item.kind != scheduler::DebugItem::Kind::value) continue;
    auto found = robot.logged.find(item.name);
    if (found == robot.logged.end()) {
      if (robot.logged.size() == kMostNames) continue;
      const int name = names_.add(plain_name(robot.id + "." + item.name));
      found = robot.logged.emplace(item.name, name).first;
    }
    give(found->second, time, item.value);
  }
}

}  // namespace seam::app
