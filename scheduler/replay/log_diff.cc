#include "scheduler/replay/log_diff.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "scheduler/wire/wire.h"
#include "sim_core/base/config.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {
namespace {

template <typename Names>
std::string joined(const Names& names) {
  return fmt::format("[{}]", fmt::join(names, ", "));
}

// What stands at each key of a scenario's text, by its path.
void add_values(const ConfigNode& node, const std::string& path,
                std::map<std::string, std::string>& values) {
  if (node.is_map()) {
    for (const std::string& key : node.keys())
      add_values(node.at(key), path.empty() ? key : path + "." + key, values);
  } else if (node.is_scalar() || node.is_null()) {
    values[path] = node.is_null() ? "" : node.text();
  } else {
    size_t i = 0;
    for (const ConfigNode& item : node.items())
      add_values(item, fmt::format("{}[{}]", path, i++), values);
  }
}

std::map<std::string, std::string> values_of(const RunHeader& header) {
  std::map<std::string, std::string> values;
  try {
    add_values(ConfigNode::from_text(header.scenario_text, header.scenario_name), "", values);
  } catch (const InputError&) {
    values.clear();  // No YAML: only that the texts differ is known.
  }
  return values;
}

// The first keys in which two scenarios differ, with both values.
std::string scenario_difference(const RunHeader& a, const RunHeader& b) {
  constexpr size_t kShown = 3, kLongest = 60;
  const auto values_a = values_of(a), values_b = values_of(b);
  std::map<std::string, std::pair<std::string, std::string>> others;
  for (const auto& [path, value] : values_a) others[path].first = value;
  for (const auto& [path, value] : values_b) others[path].second = value;
  std::erase_if(others, [](const auto& item) { return item.second.first == item.second.second; });
  std::string text = a.scenario_name == b.scenario_name
                         ? fmt::format("scenario {}", a.scenario_name)
                         : fmt::format("scenarios {} and {}", a.scenario_name, b.scenario_name);
  if (others.empty()) return text + ": written in other words";
  size_t shown = 0;
  const auto value = [](const std::string& whole) {
    return whole.empty() ? "nothing" : whole.substr(0, kLongest);
  };
  for (const auto& [path, both] : others) {
    if (shown == kShown) break;
    text += fmt::format("{} {}: {} and {}", shown++ == 0 ? ":" : ";", path, value(both.first),
                        value(both.second));
  }
  if (others.size() > kShown) text += fmt::format("; {} more keys", others.size() - kShown);
  return text;
}

void compare_headers(const RunHeader& a, const RunHeader& b, std::vector<std::string>& found) {
  if (a.seed != b.seed) found.push_back(fmt::format("seed: {} and {}", a.seed, b.seed));
  if (a.scenario_text != b.scenario_text) {
    found.push_back(scenario_difference(a, b));
  }
  if (a.robots != b.robots) {
    found.push_back(fmt::format("robots: {} and {}", joined(a.robots), joined(b.robots)));
  }
  const std::map<std::string, std::string> versions_a(a.versions.begin(), a.versions.end());
  for (const auto& [name, version] : b.versions) {
    const auto other = versions_a.find(name);
    if (other != versions_a.end() && other->second != version) {
      found.push_back(fmt::format("version of {}: {} and {}", name, other->second, version));
    }
  }
}

// The bytes of one robot's decision, without what makes no difference to the run.
std::string decision_bytes(Answer answer, const std::vector<std::string>& robots) {
  answer.decision.debug.clear();
  Turn turn;
  turn.answers.push_back(std::move(answer));
  return encode_turn(SimTime(), turn, robots);
}

// The newest frame that a robot had been sent at an instant.
std::optional<FrameRecord> newest_frame(const Log& log, int robot, SimTime time) {
  std::optional<FrameRecord> newest;
  LogCursor cursor(log, {Topic::frame});
  while (const std::optional<LogRecord> record = cursor.next()) {
    const FrameRecord& frame = std::get<FrameRecord>(*record);
    if (frame.time > time) break;
    if (frame.robot == robot) newest = frame;
  }
  return newest;
}

std::optional<LogDifference::FirstDecision> first_other_decision(const Log& a, const Log& b) {
  LogCursor cursor_a(a, {Topic::turn});
  LogCursor cursor_b(b, {Topic::turn});
  while (true) {
    std::optional<LogRecord> record_a = cursor_a.next();
    std::optional<LogRecord> record_b = cursor_b.next();
    if (!record_a || !record_b) return std::nullopt;
    const TurnRecord& turn_a = std::get<TurnRecord>(*record_a);
    const TurnRecord& turn_b = std::get<TurnRecord>(*record_b);
    const SimTime time = std::min(turn_a.time, turn_b.time);
    if (turn_a.time != turn_b.time || turn_a.turn.answers.size() != turn_b.turn.answers.size()) {
      return LogDifference::FirstDecision{time, ""};
    }
    if (cursor_a.last_bytes() == cursor_b.last_bytes()) continue;
    for (size_t i = 0; i < turn_a.turn.answers.size(); ++i) {
      const Answer& answer_a = turn_a.turn.answers[i];
      const Answer& answer_b = turn_b.turn.answers[i];
      const std::string& name_a = a.header().robots.at(static_cast<size_t>(answer_a.robot));
      if (name_a != b.header().robots.at(static_cast<size_t>(answer_b.robot)))
        return LogDifference::FirstDecision{time, name_a};
      if (decision_bytes(answer_a, a.header().robots) !=
          decision_bytes(answer_b, b.header().robots)) {
        using Side = LogDifference::FirstDecision::Side;
        return LogDifference::FirstDecision{time, name_a,
                                            Side{answer_a, newest_frame(a, answer_a.robot, time)},
                                            Side{answer_b, newest_frame(b, answer_b.robot, time)}};
      }
    }
    if (turn_a.turn.actions.size() != turn_b.turn.actions.size()) {
      return LogDifference::FirstDecision{time, "supervisor"};
    }
  }
}

// Notes when each section differs for the first time.
class Spreading {
 public:
  explicit Spreading(std::vector<LogDifference::Spread>& spread) : spread_(spread) {}

  void differs(SimTime time, const std::string& section) {
    if (seen_.insert(section).second) spread_.push_back({time, section});
  }

 private:
  std::vector<LogDifference::Spread>& spread_;
  std::set<std::string> seen_;
};

void compare_steps(const StepRecord& a, const StepRecord& b,
                   const std::vector<std::string>& names_a,
                   const std::map<std::string, size_t>& places_b, Spreading& spreading) {
  if (a.fingerprint == b.fingerprint) return;
  for (size_t i = 0; i < a.section_hashes.size() && i < names_a.size(); ++i) {
    const auto place = places_b.find(names_a[i]);
    if (place == places_b.end()) continue;  // Named in the header.
    if (place->second >= b.section_hashes.size() ||
        a.section_hashes[i] != b.section_hashes[place->second]) {
      spreading.differs(a.time, names_a[i]);
    }
  }
}

// Steps are aligned by time: runs may have steps of other lengths.
void compare_states(const Log& a, const Log& b, LogDifference& difference) {
  std::map<std::string, size_t> places_b;
  for (size_t i = 0; i < b.header().sections.size(); ++i) places_b[b.header().sections[i]] = i;
  Spreading spreading(difference.spread);
  LogCursor cursor_a(a, {Topic::step});
  LogCursor cursor_b(b, {Topic::step});
  std::optional<LogRecord> record_a = cursor_a.next();
  std::optional<LogRecord> record_b = cursor_b.next();
  while (record_a && record_b) {
    const StepRecord& step_a = std::get<StepRecord>(*record_a);
    const StepRecord& step_b = std::get<StepRecord>(*record_b);
    if (step_a.time == step_b.time) {
      compare_steps(step_a, step_b, a.header().sections, places_b, spreading);
      difference.compared_until = step_a.time;
    }
    const bool next_a = step_a.time <= step_b.time;
    const bool next_b = step_b.time <= step_a.time;
    if (next_a) record_a = cursor_a.next();
    if (next_b) record_b = cursor_b.next();
  }
}

void compare_frames(const Log& a, const Log& b, LogDifference& difference) {
  // Of robots that both runs have; others are named in the header.
  const auto frames_of = [](const Log& log, const std::vector<std::string>& robots) {
    std::map<std::pair<std::string, uint64_t>, FrameRecord> frames;
    LogCursor cursor(log, {Topic::frame});
    while (const std::optional<LogRecord> record = cursor.next()) {
      const FrameRecord& frame = std::get<FrameRecord>(*record);
      const std::string& robot = log.header().robots[static_cast<size_t>(frame.robot)];
      if (std::find(robots.begin(), robots.end(), robot) == robots.end()) continue;
      frames[{robot, frame.index}] = frame;
    }
    return frames;
  };
  const auto frames_a = frames_of(a, b.header().robots);
  const auto frames_b = frames_of(b, a.header().robots);
  std::map<std::string, SimTime> first;  // By robot.
  const auto differs = [&](const std::string& robot, SimTime time) {
    const auto [place, is_new] = first.emplace(robot, time);
    if (!is_new) place->second = std::min(place->second, time);
  };
  for (const auto& [key, frame] : frames_a) {
    const auto other = frames_b.find(key);
    const bool missing = other == frames_b.end() && frame.time <= difference.compared_until;
    const bool different =
        other != frames_b.end() && other->second.fingerprint != frame.fingerprint;
    if (missing || different) differs(key.first, frame.time);
  }
  for (const auto& [key, frame] : frames_b) {
    if (!frames_a.contains(key) && frame.time <= difference.compared_until) {
      differs(key.first, frame.time);
    }
  }
  for (const auto& [robot, time] : first) difference.spread.push_back({time, "frame/" + robot});
  std::stable_sort(difference.spread.begin(), difference.spread.end(),
                   [](const auto& x, const auto& y) { return x.time < y.time; });
}

std::string text_of(const StateSection::Field& field) {
  return std::visit([](auto value) { return fmt::format("{}", value); }, field.value);
}

const StateSection* find_section(const std::vector<StateSection>& sections,
                                 const std::string& name) {
  const auto found =
      std::find_if(sections.begin(), sections.end(),
                   [&](const StateSection& section) { return section.name == name; });
  return found == sections.end() ? nullptr : &*found;
}

}  // namespace

LogDifference compare_logs(const Log& a, const Log& b) {
  LogDifference difference;
  compare_headers(a.header(), b.header(), difference.header);
  difference.end_a = a.end_time();
  difference.end_b = b.end_time();
  difference.first_decision = first_other_decision(a, b);
  compare_states(a, b, difference);
  compare_frames(a, b, difference);
  if (!difference.spread.empty()) {
    difference.first = {difference.spread[0].time, difference.spread[0].section, "", "", ""};
  }
  return difference;
}

void name_field(LogDifference& difference, const StateAt& state_a, const StateAt& state_b) {
  if (!difference.first) return;
  LogDifference::First& first = *difference.first;
  if (first.section.starts_with("frame/")) {
    first.field = "pixels";
    return;
  }
  const std::vector<StateSection> sections_a = state_a(first.time);
  const std::vector<StateSection> sections_b = state_b(first.time);
  const StateSection* a = find_section(sections_a, first.section);
  const StateSection* b = find_section(sections_b, first.section);
  if (a == nullptr || b == nullptr) return;
  for (size_t i = 0; i < std::max(a->fields.size(), b->fields.size()); ++i) {
    const bool in_a = i < a->fields.size();
    const bool in_b = i < b->fields.size();
    if (in_a && in_b && a->fields[i] == b->fields[i]) continue;
    first.field = (in_a ? a : b)->fields[i].name;
    first.a = in_a ? text_of(a->fields[i]) : "";
    first.b = in_b ? text_of(b->fields[i]) : "";
    return;
  }
}

}  // namespace seam::scheduler
