#include "app/import/servo/servo_join.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "app/import/bags/reading_progress.h"
#include "app/import/draft/checks.h"
#include "app/import/servo/feature_names.h"
#include "app/import/servo/servo_columns.h"
#include "app/import/servo/servo_roles.h"
#include "measurement/numerics/moments.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

struct Source {
  fs::path path;
  SignalLog log;
  Role role = Role::unknown;
  std::string quantity;  // The column of its angles where the user says it (--map ROLE=FILE:NAME).
};

// "control.csv:positions" of this file: "positions".
std::string column_in_file(const std::string& mapped, const fs::path& path) {
  const size_t colon = mapped.rfind(':');
  if (colon == std::string::npos || colon + 1 == mapped.size()) return "";
  const fs::path file = mapped.substr(0, colon);
  const bool same = file == path || file == path.filename();
  return same ? mapped.substr(colon + 1) : "";
}

bool holds_both(const ImportRequest& request, const SignalLog& log) {
  try {
    servo_joints(request, log);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

Role role_of(const SignalLog& log, const fs::path& path) {
  for (const std::string& name : {path.stem().string(), path.parent_path().filename().string()}) {
    if (const Role role = role_in(name); role != Role::unknown) return role;
  }
  for (const auto& [name, words] : log.texts) {
    if (words.empty() || name.find('[') != std::string::npos) continue;
    if (const Role role = role_in(words.front()); role != Role::unknown) return role;
  }
  const bool command = log.find(servo_names().commands) >= 0;
  const bool state = log.find(servo_names().measured) >= 0;
  return command == state ? Role::unknown : command ? Role::command : Role::state;
}

// Pairs of a log of commands and one of states: the only ones, alone in their folder, or alike in
// what their names say besides.
std::vector<std::pair<size_t, size_t>> pairs_of(const std::vector<Source>& sources) {
  const auto stem = [](const Source& s) { return without_role(s.path.stem().string()); };
  const auto folder = [](const Source& s) {
    return without_role(s.path.parent_path().filename().string());
  };
  const std::function<std::string(const Source&)> keys[] = {
      [](const Source&) { return std::string(); },
      [](const Source& s) { return s.path.parent_path().string(); },
      [&](const Source& s) { return s.path.parent_path().string() + "/" + stem(s); },
      [&](const Source& s) {
        return s.path.parent_path().parent_path().string() + "/" + folder(s) + "/" + stem(s);
      }};
  for (const auto& key : keys) {
    std::map<std::string, std::pair<std::vector<size_t>, std::vector<size_t>>> groups;
    for (size_t i = 0; i < sources.size(); ++i) {
      auto& [commands, states] = groups[key(sources[i])];
      (sources[i].role == Role::command ? commands : states).push_back(i);
    }
    std::vector<std::pair<size_t, size_t>> pairs;
    for (const auto& [name, group] : groups) {
      if (group.first.size() == 1 && group.second.size() == 1)
        pairs.emplace_back(group.first[0], group.second[0]);
    }
    if (pairs.size() == groups.size()) return pairs;
  }
  Names spans;
  for (const Source& s : sources)
    spans.push_back(
        fmt::format("{} ({})", s.path.string(), s.role == Role::command ? "commands" : "states"));
  throw InputError(
      fmt::format("found no pairs of a file of commands and one of states among {}: import a run "
                  "at a time, or give both files of a run the same name in two folders",
                  fmt::join(spans, ", ")));
}

// The signals of an angle: a list's by their places, or one. Empty where there is none.
std::vector<size_t> angles_in(const Source& source) {
  Names names = source.role == Role::command ? servo_names().commands : servo_names().measured;
  const Names& other =
      source.role == Role::command ? servo_names().measured : servo_names().commands;
  names.insert(names.end(), other.begin(), other.end());
  names.insert(names.begin(), {"positions", "joint_positions", "angles"});
  if (!source.quantity.empty()) names = {source.quantity};
  for (const std::string& name : names) {
    std::vector<size_t> found;
    for (int at = 0; (at = source.log.find({fmt::format("{}[{}]", name, found.size())})) >= 0;)
      found.push_back(static_cast<size_t>(at));
    if (found.empty()) {
      const int at = source.log.find({name});
      if (at >= 0) found.push_back(static_cast<size_t>(at));
    }
    if (!found.empty()) return found;
  }
  return {};
}

class Join {
 public:
  Join(const ImportRequest& request, const Source& command, const Source& state)
      : request_(request), command_(command), state_(state), joined_(state.log) {}

  SignalLog run() {
    const auto commands = angles_in(command_), states = angles_in(state_);
    if (!commands.empty() && !states.empty()) {
      take_lists(commands, states);
    } else {
      take_same_names();
    }
    join();
    return std::move(joined_);
  }
  // States without a command before them.
  size_t early() const { return early_; }
  // By command, how long after it the state comes from which on it counts.
  const std::vector<double>& late_ns() const { return late_ns_; }

 private:
  // By the names of joints where both files have them, else by their places.
  void take_lists(const std::vector<size_t>& commands, const std::vector<size_t>& states) {
    const Names of_commands = joint_names_in(command_.log), of_states = joint_names_in(state_.log);
    const bool by_name = of_commands.size() == commands.size() && of_states.size() == states.size();
    if (!by_name && commands.size() != states.size())
      throw InputError(fmt::format(
          "{} has {} commands, {} has {} angles, expected as many or names of joints beside both",
          command_.path.string(), commands.size(), state_.path.string(), states.size()));
    size_t count = 0;
    Names joints;
    for (size_t i = 0; i < states.size(); ++i) {
      size_t from = i;
      if (by_name) {
        const auto found = std::find(of_commands.begin(), of_commands.end(), of_states[i]);
        if (found == of_commands.end()) continue;
        from = static_cast<size_t>(found - of_commands.begin());
      }
      const bool single = states.size() == 1 && joint_names_in(state_.log).empty();
      take(commands[from], states[i], single ? "command" : fmt::format("command[{}]", count),
           single ? "measured" : fmt::format("measured[{}]", count));
      const Names& named = of_states.size() == states.size() ? of_states : of_commands;
      if (i < named.size()) joints.push_back(named[i]);
      ++count;
    }
    if (!joints.empty()) joined_.lists["joint_names"] = joints;
    if (count == 0)
      throw InputError(fmt::format("{} and {} have no joint in common", command_.path.string(),
                                   state_.path.string()));
  }

  // A column a joint, called alike in both files.
  void take_same_names() {
    Names others = servo_names().times;
    others.insert(others.end(), {"run", "joint", "episode_index", "frame_index", "index"});
    size_t count = 0;
    for (size_t s = 0; s < state_.log.names.size(); ++s) {
      const std::string name = state_.log.names[s];
      const int c = command_.log.find({name});
      const bool no_angle =
          std::find(others.begin(), others.end(), name) != others.end() ||
          name == request_.name_of("time") || name.find("vel") != std::string::npos ||
          name.find("effort") != std::string::npos || name.find("torque") != std::string::npos;
      if (c < 0 || no_angle) continue;
      take(static_cast<size_t>(c), s, name + "_ctrl", name + "_qpos");
      ++count;
    }
    if (count == 0)
      throw InputError(
          fmt::format("{} and {}: found no angles in both among {} and {}; state which, --map "
                      "command=NAME,measured=NAME (FILE:NAME where both files have the name)",
                      command_.path.string(), state_.path.string(),
                      fmt::join(command_.log.names, ", "), fmt::join(state_.log.names, ", ")));
  }

  void take(size_t command, size_t state, const std::string& command_name,
            const std::string& state_name) {
    // The state's column gets our name, which no other column may have.
    if (const int taken = joined_.find({state_name}); taken >= 0)
      joined_.names[static_cast<size_t>(taken)] += "_in_file";
    joined_.names[state] = state_name;
    taken_.push_back(command);
    joined_.names.push_back(command_name);
    joined_.full_names.push_back(command_.log.full_names[command]);
    joined_.values.emplace_back();
    joined_.exact_ns.emplace_back();
  }

  std::vector<int64_t> times_of(const SignalLog& log) const {
    const size_t time = servo_signal(request_, log, "time", servo_names().times);
    const int64_t unit = time_unit_ns(request_, log.full_names[time]);
    const bool exact = !log.exact_ns.empty() && unit == nanoseconds_in("s");
    std::vector<int64_t> ns;
    for (size_t row = 0; row < log.rows(); ++row) {
      const double t = log.values[time][row];
      if (!(std::abs(t) * static_cast<double>(unit) < 9e18))
        throw InputError(fmt::format("{}: {}: found '{}', expected a time", log.places[row],
                                     log.names[time], t));
      ns.push_back(exact ? log.exact_ns[time][row] : std::llround(t * static_cast<double>(unit)));
    }
    return ns;
  }

  // The columns that name the run and the joint of a row.
  std::string key_of(const SignalLog& log, size_t row) const {
    std::string key;
    for (const std::string& name :
         {request_.name_of("run"), request_.name_of("joint"), std::string("run"),
          std::string("joint"), std::string("episode_index")}) {
      if (name.empty()) continue;
      const auto words = log.texts.find(name);
      const int at = log.find({name});
      if (words != log.texts.end() && row < words->second.size()) {
        key += words->second[row] + "\n";
      } else if (at >= 0) {
        key += exact(log.values[static_cast<size_t>(at)][row]) + "\n";
      }
    }
    return key;
  }

  void join() {
    const std::vector<int64_t> asked = times_of(command_.log), seen = times_of(state_.log);
    std::map<std::string, std::map<int64_t, size_t>> rows;  // Of commands, by key and time.
    for (size_t row = 0; row < asked.size(); ++row)
      rows[key_of(command_.log, row)][asked[row]] = row;
    std::vector<size_t> kept, command_rows;
    for (size_t row = 0; row < seen.size(); ++row) {
      const auto of_key = rows.find(key_of(state_.log, row));
      if (of_key == rows.end()) continue;
      const auto after = of_key->second.upper_bound(seen[row]);
      if (after == of_key->second.begin()) continue;
      const auto& [asked_ns, command] = *std::prev(after);
      if (command_rows.empty() || command_rows.back() != command)
        late_ns_.push_back(static_cast<double>(seen[row] - asked_ns));
      kept.push_back(row), command_rows.push_back(command);
    }
    early_ = seen.size() - kept.size();
    if (kept.size() < 3)
      throw InputError(
          fmt::format("{} and {} do not overlap in time: {} states have a command before them",
                      command_.path.string(), state_.path.string(), kept.size()));
    const size_t own = joined_.names.size() - taken_.size();
    for (size_t c = 0; c < own; ++c) {
      joined_.values[c] = picked(joined_.values[c], kept);
      if (c < joined_.exact_ns.size()) joined_.exact_ns[c] = picked(joined_.exact_ns[c], kept);
    }
    for (size_t i = 0; i < taken_.size(); ++i) {
      joined_.values[own + i] = picked(command_.log.values[taken_[i]], command_rows);
      joined_.exact_ns[own + i].assign(kept.size(), 0);
    }
    for (auto& [name, words] : joined_.texts) {
      if (words.size() == seen.size()) words = picked(words, kept);
    }
    joined_.places = picked(joined_.places, kept);
  }

  template <typename T>
  static std::vector<T> picked(const std::vector<T>& values, const std::vector<size_t>& rows) {
    std::vector<T> some;
    for (const size_t row : rows) {
      if (row < values.size()) some.push_back(values[row]);
    }
    return some;
  }

  const ImportRequest& request_;
  const Source& command_;
  const Source& state_;
  SignalLog joined_;
  std::vector<size_t> taken_;  // Of the commands, behind the state's own signals.
  size_t early_ = 0;
  std::vector<double> late_ns_;
};

// Where the user names files, their roles are his.
void take_roles(const ImportRequest& request, std::vector<Source>& sources) {
  for (Source& source : sources) {
    for (const auto& [quantity, role] :
         {std::pair("command", Role::command), {"measured", Role::state}}) {
      const std::string column = column_in_file(request.name_of(quantity), source.path);
      if (!column.empty()) source.role = role, source.quantity = column;
    }
    if (source.role == Role::unknown) source.role = role_of(source.log, source.path);
    if (source.role == Role::unknown)
      throw InputError(fmt::format(
          "{}: are these commands or measured angles? Say it by the file's name, or --map "
          "command=FILE:NAME,measured=FILE:NAME",
          source.path.string()));
    if (source.quantity.empty())
      source.quantity = request.name_of(source.role == Role::command ? "command" : "measured");
  }
}

}  // namespace

ServoLogs servo_logs(const ImportRequest& request, SetDraft& draft) {
  std::vector<Source> sources;
  ReadingProgress progress("servo", request.sources.size(), "files", 1);
  FeatureNames names;
  for (const auto& path : request.sources)
    if (is_feature_file(path)) names.merge(read_feature_names(path));
  for (const auto& path : request.sources) {
    if (is_feature_file(path)) continue;
    progress.at(sources.size());
    sources.push_back({path, read_signals(path)});
    name_features(sources.back().log, names);
  }
  if (sources.empty())
    throw InputError(
        fmt::format("{}: holds names of numbers alone, expected the episodes beside it",
                    request.sources.front().string()));
  const bool apart =
      sources.size() > 1 && std::none_of(sources.begin(), sources.end(), [&](const Source& source) {
        return holds_both(request, source.log);
      });
  ServoLogs found{.request = request};
  if (!apart) {
    for (Source& source : sources) {
      found.logs.push_back(std::move(source.log));
      found.runs.push_back(source.path.stem().string());
    }
    return found;
  }
  take_roles(request, sources);
  found.request.names.erase("command"), found.request.names.erase("measured");
  const auto pairs = pairs_of(sources);
  size_t early = 0, states = 0;
  std::vector<double> late_ns;
  for (const auto& [command, state] : pairs) {
    const Source& of_states = sources[state];
    Join join(request, sources[command], of_states);
    const fs::path folder = of_states.path.parent_path().filename();
    const bool by_folder = pairs.size() > 1 && !folder.empty() && role_in(folder) == Role::unknown;
    const std::string stem = of_states.path.stem().string();
    found.logs.push_back(join.run());
    found.runs.push_back(by_folder ? folder.string() + "-" + stem : stem);
    early += join.early(), states += of_states.log.rows();
    late_ns.insert(late_ns.end(), join.late_ns().begin(), join.late_ns().end());
  }
  draft.did(fmt::format(
      "commands and states of {} pairs of files joined by time: a state has the last command at or "
      "before it{}",
      pairs.size(),
      early > 0
          ? fmt::format("; {} of {} states stand before the first command: left out", early, states)
          : ""));
  constexpr double kMatters_ns = 1e5;
  if (const double late = measurement::mean_of(late_ns); late > kMatters_ns)
    draft.could_not_know(fmt::format(
        "when commands acted between states: each counts from the next state on, {:.2g} ms after "
        "it "
        "on average ({:.2g} ms at most), and what delays a joint is found wrong by as much; a log "
        "of both in one row has no such error",
        late * 1e-6, *std::max_element(late_ns.begin(), late_ns.end()) * 1e-6));
  return found;
}

}  // namespace seam::app
