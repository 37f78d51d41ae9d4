#include "app/import/servo/servo_columns.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using Names = std::vector<std::string>;

// The place of a list's item: position[0], or as it is written in a table, position_0, position0.
int item_in(const SignalLog& log, const std::string& list, size_t item) {
  for (const char* between : {"[", "_", ".", ""}) {
    const int at =
        log.find({fmt::format("{}{}{}{}", list, between, item, *between == '[' ? "]" : "")});
    if (at >= 0) return at;
  }
  return -1;
}

size_t items_in(const SignalLog& log, const std::string& list) {
  size_t count = 0;
  while (item_in(log, list, count) >= 0) ++count;
  return count;
}

// position[0], position[1], ... beside goal_position[0], goal_position[1], ...
std::vector<JointColumns> numbered_joints(const ImportRequest& request, const SignalLog& log) {
  const auto first = [&](const std::string& quantity, const Names& usual) {
    for (const std::string& name : names_of(request, quantity, usual)) {
      if (item_in(log, name, 0) >= 0) return name;
    }
    return std::string();
  };
  const std::string command = first("command", servo_names().commands),
                    measured = first("measured", servo_names().measured);
  std::vector<JointColumns> joints;
  if (command.empty() || measured.empty()) return joints;
  const size_t commands = items_in(log, command), angles = items_in(log, measured);
  // As of a robot on a free base, whose pose comes before its joints.
  if (commands != angles)
    throw InputError(
        fmt::format("{}: {} has {} numbers, {} has {}: which belong together? Import a joint at a "
                    "time, such as "
                    "--map command={}[0],measured={}[{}]",
                    log.file, command, commands, measured, angles, command, measured,
                    angles > commands ? angles - commands : 0));
  const std::vector<std::string> named = joint_names_in(log);
  for (size_t i = 0; i < commands; ++i)
    joints.push_back({i < named.size() ? named[i] : fmt::format("joint{}", i),
                      static_cast<size_t>(item_in(log, command, i)),
                      static_cast<size_t>(item_in(log, measured, i))});
  return joints;
}

// What is left of a name without one of these at its end or start; empty where it has none.
std::string without_end(const std::string& name, const Names& ends) {
  for (const std::string& end : ends) {
    if (name.size() > end.size() && name.ends_with(end))
      return name.substr(0, name.size() - end.size());
  }
  return "";
}
std::string without_start(const std::string& name, const Names& starts) {
  for (const std::string& start : starts) {
    if (name.size() > start.size() && name.starts_with(start)) return name.substr(start.size());
  }
  return "";
}

// A joint without what its name says of the number: arm.pos, and joints.arm_rad of our episodes.
std::string plain_joint(const std::string& name) {
  const std::string without_folder = without_start(name, {"joints."});
  const std::string joint = without_folder.empty() ? name : without_folder;
  const std::string plain = without_end(joint, {".pos", "_rad"});
  return plain.empty() ? joint : plain;
}

// arm_ctrl beside arm_qpos, as MuJoCo's system identification names them, and other habits; also
// action.arm.pos beside observation.state.arm.pos.
std::vector<JointColumns> suffixed_joints(const SignalLog& log) {
  static const Names kCommandEnds = {"_ctrl",     "_cmd", "_command", "_goal", "_target",
                                     "_setpoint", "_des", "_desired", "_ref"};
  static const Names kMeasuredEnds = {"_qpos",     "_pos",    "_position", "_meas",
                                      "_measured", "_actual", "_act",      "_state",
                                      "_present",  "_angle",  "_q"};
  static const Names kCommandStarts = {"action.",   "cmd_", "command_", "goal_", "target_",
                                       "setpoint_", "des_", "desired_", "ref_"};
  static const Names kMeasuredStarts = {
      "observation.state.", "pos_", "position_", "meas_", "measured_", "actual_",
      "present_",           "q_",   "state_"};
  std::vector<JointColumns> joints;
  std::set<std::string> seen;
  const auto pair_up = [&](auto without, const Names& commands, const Names& measured) {
    for (size_t c = 0; c < log.names.size(); ++c) {
      const std::string joint = without(log.names[c], commands);
      // Of positions alone.
      const bool other =
          joint.find("vel") != std::string::npos || joint.find("torque") != std::string::npos ||
          joint.find("effort") != std::string::npos || joint.find("current") != std::string::npos;
      if (joint.empty() || other || seen.contains(joint)) continue;
      for (size_t m = 0; m < log.names.size(); ++m) {
        if (m == c || (without(log.names[m], measured) != joint && log.names[m] != joint)) continue;
        joints.push_back({plain_joint(joint), c, m});
        seen.insert(joint);
        break;
      }
    }
  };
  pair_up(without_end, kCommandEnds, kMeasuredEnds);
  pair_up(without_start, kCommandStarts, kMeasuredStarts);
  return joints;
}

}  // namespace

const ServoNames& servo_names() {
  static const ServoNames names = {
      .times = {"time_s", "time", "timestamp", "stamp", "times", "t", "time_ms", "timestamp_ms",
                "time_us", "timestamp_us", "time_ns", "timestamp_ns", "t_ms", "t_us", "t_ns",
                "stamp_ms", "stamp_us", "stamp_ns"},
      .commands = {"command_rad",
                   "command",
                   "goal_position",
                   "goal",
                   "target",
                   "target_position",
                   "setpoint",
                   "desired",
                   "reference",
                   "ref",
                   "q_des",
                   "q_ref",
                   "ctrl",
                   "cmd",
                   "action",
                   "desired_position",
                   "commanded_position",
                   "command_position",
                   "position_command",
                   "position_setpoint",
                   "target_angle",
                   "goal_angle",
                   "position_goal",
                   "position_target",
                   "target_pos",
                   "goal_pos",
                   "pos_cmd",
                   "cmd_pos",
                   "desired_pos"},
      .measured = {"measured_rad",
                   "measured",
                   "position",
                   "present_position",
                   "actual_position",
                   "pos",
                   "qpos",
                   "q",
                   "angle",
                   "actual",
                   "feedback",
                   "encoder",
                   "state",
                   "measured_position",
                   "position_measured",
                   "position_actual",
                   "present_angle",
                   "current_position",
                   "joint_position",
                   "motor_position",
                   "actual_pos",
                   "present_pos",
                   "pos_meas",
                   "actual_angle",
                   "measured_angle",
                   "observation.state"},
      .efforts = {"effort_nm", "effort", "torque_nm", "measured_torque", "torque_measured",
                  "actual_torque", "torque_actual", "present_torque", "measured_effort",
                  "joint_torque", "motor_torque"},
      .voltages = {"voltage_v", "input_volts", "voltage", "present_voltage", "vin"},
      .gains = {"kp", "p_gain", "gain"},
      .enabled = {"torque_enable", "torque_enabled", "enabled", "enable"}};
  return names;
}

const Names& effort_ends() {
  static const Names ends = {"_effort", "_effort_nm", "_torque", "_torque_nm", ".effort"};
  return ends;
}

Names names_of(const ImportRequest& request, const std::string& quantity, const Names& usual) {
  const std::string mapped = request.name_of(quantity);
  return mapped.empty() ? usual : Names{mapped};
}

void fail_missing(const ImportRequest& request, const SignalLog& log, const std::string& quantity) {
  const std::string mapped = request.name_of(quantity);
  throw InputError(fmt::format("{}: signal '{}' (--map {}=...) is missing{}", log.file, mapped,
                               quantity, suggestion_for(mapped, log.names)));
}

size_t servo_signal(const ImportRequest& request, const SignalLog& log, const std::string& quantity,
                    const Names& usual) {
  const int found = log.find(names_of(request, quantity, usual));
  if (found >= 0) return static_cast<size_t>(found);
  if (!request.name_of(quantity).empty()) fail_missing(request, log, quantity);
  throw InputError(fmt::format("{}: found no signal for '{}' among {}; say which, --map {}=NAME",
                               log.file, quantity, fmt::join(log.names, ", "), quantity));
}

std::vector<std::string> joint_names_in(const SignalLog& log) {
  for (const char* name : {"joint_names", "joints", "names", "name", "motor_names", "motors"}) {
    if (const auto found = log.lists.find(name); found != log.lists.end()) return found->second;
  }
  return {};
}

std::vector<char> servo_off_rows(const ImportRequest& request, const SignalLog& log,
                                 const JointColumns& joint) {
  std::vector<char> off(log.rows(), 0);
  if (!request.off_where) return off;
  const auto& [signal, value] = *request.off_where;
  size_t column = 0;
  if (signal == "command" || signal == "measured") {
    column = signal == "command" ? joint.command : joint.measured;
  } else {
    // A column by its own name, or by a name of ours that --map gives it.
    const auto mapped = request.names.find(signal);
    const int found = log.find({mapped == request.names.end() ? signal : mapped->second});
    if (found < 0)
      throw InputError(fmt::format("{}: signal '{}' (--off-where) is missing{}", log.file, signal,
                                   suggestion_for(signal, log.names)));
    column = static_cast<size_t>(found);
  }
  for (size_t row = 0; row < off.size(); ++row) {
    const double at = log.values[column][row];
    off[row] = std::isnan(value) ? std::isnan(at) : at == value;
  }
  return off;
}

namespace {

void add_efforts(const ImportRequest& request, const SignalLog& log,
                 std::vector<JointColumns>& joints) {
  const std::string mapped = request.name_of("effort");
  const Names usual = names_of(request, "effort", servo_names().efforts);
  const auto list = std::find_if(usual.begin(), usual.end(), [&](const std::string& name) {
    return items_in(log, name) == joints.size();
  });
  for (size_t i = 0; i < joints.size(); ++i) {
    int at = joints.size() == 1 ? log.find(usual) : -1;
    if (at < 0 && list != usual.end()) at = item_in(log, *list, i);
    for (const std::string& end : effort_ends()) {
      if (at < 0 && mapped.empty()) at = log.find({joints[i].joint + end});
    }
    if (at >= 0) joints[i].effort = static_cast<size_t>(at);
  }
  const bool found = std::any_of(joints.begin(), joints.end(), [](const JointColumns& joint) {
    return joint.effort.has_value();
  });
  if (!mapped.empty() && !found)
    throw InputError(
        fmt::format("{}: signal '{}' (--map effort=...) is missing{}, or has not one "
                    "number for each of {} joints",
                    log.file, mapped, suggestion_for(mapped, log.names), joints.size()));
}

std::vector<JointColumns> angles_of_joints(const ImportRequest& request, const SignalLog& log) {
  const bool mapped = !request.name_of("command").empty() || !request.name_of("measured").empty();
  if (!mapped && log.find(servo_names().commands) < 0) {
    auto joints = suffixed_joints(log);
    if (!joints.empty()) return joints;
  }
  auto joints = numbered_joints(request, log);
  if (!joints.empty()) return joints;
  const std::string named = request.name_of("joint");
  const bool column = log.texts.contains(named.empty() ? "joint" : named);
  return {{column || named.empty() ? "joint" : named,
           servo_signal(request, log, "command", servo_names().commands),
           servo_signal(request, log, "measured", servo_names().measured)}};
}

}  // namespace

std::vector<JointColumns> servo_joints(const ImportRequest& request, const SignalLog& log) {
  std::vector<JointColumns> joints = angles_of_joints(request, log);
  add_efforts(request, log, joints);
  return joints;
}

}  // namespace seam::app
