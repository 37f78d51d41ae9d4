// What the records of a run say as numbers over time, by the names that conditions and rewards
// read:
//
//   time_s                     simulated seconds
//   red1.NAME                  what red1's client logged as a value; holds until the next one
//   red1.command.pan_rad       what red1's client ordered, by the names of the viewer's series
//   truth.red1.x_m             truth: x_m, y_m, heading_rad, ball_distance_m (on the field), and
//                              joints such as pan_rad
//   truth.ball.x_m             x_m, y_m, z_m
//   event.goal                 1 at the instant of such an event, else 0
//   red1.event.kick            the same of red1's own
//   red1.event.printed         red1's behaviour printed a line, made a decision, was sent a frame:
//                              printed, decision, frame
//
// Characters that cannot stand in such a name are written `_` in it: robot `red-1` is `red_1`.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "scheduler/log/log_records.h"

namespace seam::app {

// `text` with `_` for characters that a name cannot hold.
std::string plain_name(std::string text);
// Whether a signal is 1 at its samples' own instants alone.
bool is_event(const std::string& name);

// A robot as signals name it.
struct SignalRobot {
  std::string id;
  bool has_head = true;  // Of tilt, pan and roll, which are part of its pose.
  std::function<std::string(int joint)> joint_name;
};

// Names of signals, and their places among those that are wanted.
class SignalNames {
 public:
  static constexpr int kNobody = -1;

  explicit SignalNames(const std::vector<std::string>& wanted);
  // The place of a name among those wanted, or kNobody.
  int add(const std::string& name);
  // A family of names: whether one of them is wanted.
  bool wants(const std::function<bool(const std::string&)>& is_one) const;
  bool wants_part(std::string_view part) const;
  bool knows(const std::string& name) const { return known_.contains(name); }
  std::vector<std::string> all() const { return {known_.begin(), known_.end()}; }
  // ", did you mean 'x'?", where a known name is near: there are too many to list all.
  std::string near(const std::string& unknown) const;

 private:
  std::unordered_map<std::string, int> wanted_;
  std::set<std::string> known_;
};

class RecordSignals {
 public:
  // Gets each number of a wanted name, by the name's place among those wanted.
  using Give = std::function<void(int name, SimTime time, double value)>;

  RecordSignals(const std::vector<SignalRobot>& robots, const std::vector<std::string>& wanted,
                Give give);

  void take_event(const scheduler::SimulationEvent& event);
  void take_frame(int robot, SimTime time);
  void take_printed(const std::string& robot, SimTime time);
  void take_turn(SimTime time, const scheduler::Turn& turn);
  // As StepRecord::poses; of another size they are left out.
  void take_poses(SimTime time, std::span<const double> poses);
  // A joint's true angle; `joint`: its name.
  int add_joint(size_t robot, const std::string& joint);
  void give(int name, SimTime time, double value) const;

  SignalNames& names() { return names_; }
  size_t robots() const { return robots_.size(); }

 private:
  struct OfRobot {
    std::string id;
    std::function<std::string(int joint)> joint_name;
    std::vector<int> truth;  // By pose field, then the ball's distance.
    std::unordered_map<std::string, int> logged;
    std::map<std::pair<int, std::string>, int> commands;  // By joint, or -1 and the name.
  };

  void add_fixed_names(const std::vector<SignalRobot>& robots);
  int own_event(int robot, const char* name);
  int command_name(OfRobot& robot, int joint, const char* name);
  void take_answer(SimTime time, const scheduler::Answer& answer);

  SignalNames names_;
  Give give_;
  std::vector<OfRobot> robots_;
  std::vector<int> ball_;
};

}  // namespace seam::app
