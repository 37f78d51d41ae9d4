#include "app/import/bags/controller_state.h"

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using Names = std::vector<std::string>;

// Both from the newest name to the oldest.
const Names& command_words() {
  static const Names words = {
      "reference", "desired",       "set_point",        "setpoint",        "goal",
      "target",    "goal_position", "goal_pos",         "target_position", "goal_positions",
      "commanded", "command",       "position_command", "command_position"};
  return words;
}
const Names& measured_words() {
  static const Names words = {
      "feedback",         "actual",      "process_value",     "state",
      "current",          "measured",    "present",           "present_position",
      "current_position", "current_pos", "present_positions", "measured_position",
      "actual_position",  "position"};
  return words;
}

Names words_in(const std::string& path) {
  Names parts;
  for (size_t start = 0; start <= path.size();) {
    const size_t end = std::min(path.find('.', start), path.size());
    parts.push_back(path.substr(start, end - start));
    start = end + 1;
  }
  return parts;
}

std::string joined(const Names& parts, size_t count) {
  std::string path;
  for (size_t i = 0; i < count; ++i) path += (i > 0 ? "." : "") + parts[i];
  return path;
}

// "/arm/elbow_controller/state" -> "elbow_controller"; "/elbow" -> "elbow".
std::string joint_of_topic(const std::string& topic) {
  const size_t last = topic.rfind('/');
  if (last == std::string::npos || last == 0) return topic.substr(last == 0 ? 1 : 0);
  const size_t before = topic.rfind('/', last - 1);
  return topic.substr(before == std::string::npos ? 0 : before + 1,
                      last - (before == std::string::npos ? 0 : before + 1));
}

}  // namespace

std::optional<ControllerState> ControllerState::of(const BagTopic& topic) {
  if (topic.definition.empty()) return std::nullopt;
  ControllerState state(topic, RosDefinition(topic.type, topic.definition));
  state.find_pairs();
  if (state.pairs_.empty()) return std::nullopt;
  const std::string name = topic.type.substr(topic.type.find('/') + 1);
  state.known_ =
      topic.type.starts_with("control_msgs/") || name.find("ControllerState") != std::string::npos;
  return state;
}

void ControllerState::find_pairs() {
  for (const std::string& command : command_words()) {
    for (const std::string& measured : measured_words()) {
      for (size_t at = 0; at < definition_.fields().size(); ++at) {
        const RosDefinition::Field& field = definition_.fields()[at];
        if (field.is_text) continue;
        Names parts = words_in(field.path);
        const std::string last = parts.back();
        // The quantity itself, or the position of a point.
        size_t role = parts.size() - 1;
        if (last == "positions" || last == "position") role = parts.size() - 2;
        if (role >= parts.size() || parts[role] != command) continue;
        parts[role] = measured;
        const int other = definition_.find(joined(parts, parts.size()));
        if (other < 0 || definition_.fields()[static_cast<size_t>(other)].is_text) continue;
        pairs_.push_back({at, static_cast<size_t>(other), names_near(joined(parts, role))});
      }
    }
  }
}

// Beside the fields, or at the top of the message.
int ControllerState::names_near(const std::string& prefix) const {
  for (const std::string& within : {prefix.empty() ? "" : prefix + ".", std::string()}) {
    for (const char* name : {"joint_names", "joint_name", "dof_names", "names", "name"}) {
      const int found = definition_.find(within + name);
      if (found >= 0 && definition_.fields()[static_cast<size_t>(found)].is_text) return found;
    }
  }
  return -1;
}

std::string ControllerState::fields_text() const {
  return fmt::format("{} and {}", definition_.fields()[pairs_[last_].command].path,
                     definition_.fields()[pairs_[last_].measured].path);
}

std::vector<std::string> ControllerState::names_of(const RosDefinition::Values& values,
                                                   const Pair& pair) const {
  const size_t count = values.numbers[pair.command].size();
  if (pair.names >= 0 && values.texts[static_cast<size_t>(pair.names)].size() == count)
    return values.texts[static_cast<size_t>(pair.names)];
  if (count == 1) return {joint_of_topic(topic_)};
  Names names;
  for (size_t i = 0; i < count; ++i) names.push_back(fmt::format("joint{}", i));
  return names;
}

std::optional<ControllerState::Sample> ControllerState::read(std::string_view bytes, RosForm form,
                                                             int64_t log_ns) {
  RosDefinition::Values values = definition_.read(bytes, form, topic_);
  for (size_t i = 0; i < pairs_.size(); ++i) {
    const Pair& pair = pairs_[i];
    std::vector<double>& command = values.numbers[pair.command];
    std::vector<double>& measured = values.numbers[pair.measured];
    if (command.empty() || command.size() != measured.size()) continue;
    last_ = i;
    const SharedNames& names = share_names(last_names_, names_of(values, pair));
    return Sample{values.stamp_ns != 0 ? values.stamp_ns : log_ns, names, std::move(command),
                  std::move(measured)};
  }
  return std::nullopt;
}

}  // namespace seam::app
