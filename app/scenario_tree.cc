#include "app/scenario_tree.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <functional>
#include <span>

#include "sim_core/base/config.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam::app {
namespace {

// A written scenario leaves these keys out where no file was named.
constexpr const char* kLeftOut[] = {"model", "colour_table"};

struct Step {
  std::string text;
  bool in_list = false;  // A place in a list; else a key.
};

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw InputError(fmt::format("path '{}': {}", path, why));
}

std::vector<Step> steps_of(const std::string& path) {
  constexpr const char* kForm =
      "expected keys joined by '.', with places in lists as [0], [ID] or [*], such as "
      "robots[0].pose.x_m";
  std::vector<Step> steps;
  size_t at = 0;
  while (at < path.size()) {
    const bool in_list = path[at] == '[';
    if (!steps.empty() && !in_list && path[at++] != '.') refuse(path, kForm);
    const size_t start = in_list ? at + 1 : at;
    const size_t end = in_list ? path.find(']', at) : path.find_first_of(".[", at);
    if (in_list && end == std::string::npos) refuse(path, kForm);
    steps.push_back({path.substr(start, end - start), in_list});
    if (steps.back().text.empty()) refuse(path, kForm);
    at = end == std::string::npos ? path.size() : in_list ? end + 1 : end;
  }
  if (steps.empty() || steps.front().in_list) refuse(path, kForm);
  return steps;
}

std::vector<std::string> keys_of(const YAML::Node& map) {
  std::vector<std::string> keys;
  for (const auto& entry : map) keys.push_back(entry.first.Scalar());
  return keys;
}

std::vector<std::string> ids_of(const YAML::Node& list) {
  std::vector<std::string> ids;
  for (const YAML::Node& item : list)
    ids.push_back(item.IsMap() && item["id"] ? item["id"].Scalar() : "");
  return ids;
}

// The places in a list that a step names.
std::vector<size_t> places_of(const YAML::Node& list, const Step& step, const std::string& path) {
  std::vector<size_t> places;
  if (step.text == "*") {
    for (size_t i = 0; i < list.size(); ++i) places.push_back(i);
    return places;
  }
  size_t place = 0;
  const char* end = step.text.data() + step.text.size();
  const auto [rest, error] = std::from_chars(step.text.data(), end, place);
  if (error == std::errc() && rest == end) {
    if (place >= list.size())
      refuse(path, fmt::format("[{}] is not there: the list has {} items", place, list.size()));
    return {place};
  }
  const std::vector<std::string> ids = ids_of(list);
  const auto found = std::find(ids.begin(), ids.end(), step.text);
  if (found == ids.end())
    refuse(path,
           fmt::format("no item is called '{}'{}", step.text, suggestion_for(step.text, ids)));
  return {static_cast<size_t>(found - ids.begin())};
}

struct Place {
  YAML::Node node;  // What stands there; undefined where nothing does.
  bool in_model = false;
  bool file_key = false;
};

// Calls `take` for each place that the rest of the path leads to.
void follow(YAML::Node node, std::span<const Step> steps, const std::string& path, Place place,
            const std::function<void(const Place&)>& take) {
  if (steps.empty()) {
    place.node = node;
    return take(place);
  }
  const Step& step = steps.front();
  const auto rest = steps.subspan(1);
  if (step.in_list) {
    if (!node.IsSequence()) refuse(path, fmt::format("there is no list before [{}]", step.text));
    place.file_key = false;
    for (const size_t i : places_of(node, step, path)) follow(node[i], rest, path, place, take);
    return;
  }
  if (!node.IsMap())
    refuse(path, fmt::format("what stands before '{}' has no keys of its own", step.text));
  const YAML::Node& known = node;
  place.file_key =
      std::find(std::begin(kLeftOut), std::end(kLeftOut), step.text) != std::end(kLeftOut);
  if (!known[step.text].IsDefined()) {
    if (step.text == "robot_defaults")
      refuse(path, "robots have taken over what they have in common: write robots[*]....");
    if (place.file_key && !place.in_model && !rest.empty())
      refuse(path, fmt::format("no {} is given there: name one first", step.text));
    if (!place.in_model && !place.file_key)
      refuse(path, fmt::format("unknown key '{}'{}", step.text,
                               suggestion_for(step.text, keys_of(node))));
    node[step.text] = rest.empty() ? YAML::Node() : YAML::Node(YAML::NodeType::Map);
  }
  const bool enters_model = step.text == "model";
  follow(node[step.text], rest, path, {{}, place.in_model || enters_model, place.file_key}, take);
}

// A copy each time: a tree that took over a node would keep the memory of all trees that did.
YAML::Node node_of(const WrittenValue& value) {
  return value.plain ? YAML::Node(value.text) : YAML::Load(value.text);
}

bool has_value_inside(const Place& place) {
  const YAML::Node& node = place.node;
  return place.in_model && !place.file_key && node.IsMap() && node["value"].IsDefined();
}

}  // namespace

std::optional<double> number_of(const WrittenValue& value) {
  double number = 0;
  const char* end = value.text.data() + value.text.size();
  const auto [rest, error] = std::from_chars(value.text.data(), end, number);
  if (!value.plain || error != std::errc() || rest != end) return std::nullopt;
  return number;
}

ScenarioChange change_from_text(const std::string& text) {
  const size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw UsageError(fmt::format("--set {}: expected PATH=VALUE", text));
  const std::string value = text.substr(equals + 1);
  const bool nested = !value.empty() && (value.front() == '{' || value.front() == '[');
  if (nested) ConfigNode::from_text(value, "--set " + text);  // Says where it is no YAML.
  return {text.substr(0, equals), {value, !nested}};
}

ScenarioTree::ScenarioTree(const Scenario& scenario)
    : ScenarioTree(scenario.to_yaml(), scenario.name) {}

ScenarioTree::ScenarioTree(const std::string& yaml, const std::string& name)
    : name_(name), root_(std::make_unique<YAML::Node>(YAML::Load(yaml))) {}

ScenarioTree::ScenarioTree(const ScenarioTree& other)
    : name_(other.name_), root_(std::make_unique<YAML::Node>(YAML::Clone(*other.root_))) {}

ScenarioTree::ScenarioTree(ScenarioTree&&) noexcept = default;
ScenarioTree::~ScenarioTree() = default;

void ScenarioTree::set(const std::string& path, const WrittenValue& value) {
  const std::vector<Step> steps = steps_of(path);
  follow(*root_, steps, path, {}, [&](const Place& place) {
    YAML::Node target = place.node;
    if (value.plain && has_value_inside(place)) {
      target["value"] = node_of(value);
      return;
    }
    const YAML::Node& old = target;
    if (value.plain && (old.IsMap() || old.IsSequence()))
      refuse(path, fmt::format("found '{}', expected a {}", value.text,
                               old.IsMap() ? "map of keys" : "list"));
    target = node_of(value);
  });
}

bool ScenarioTree::takes_file(const std::string& path) const {
  const std::vector<Step> steps = steps_of(path);
  bool takes = false;
  // On a copy, for a path may name what is not stated.
  follow(YAML::Clone(*root_), steps, path, {}, [&](const Place& place) {
    takes = takes || place.file_key || (place.node.IsMap() && !place.in_model);
  });
  return takes;
}

Scenario ScenarioTree::scenario() const {
  YAML::Emitter out;
  out << *root_;
  return Scenario::from_made_text(out.c_str(), name_);
}

Scenario changed_scenario(const Scenario& scenario, const std::vector<ScenarioChange>& changes,
                          const std::filesystem::path& folder) {
  if (changes.empty()) return scenario;
  ScenarioTree tree(scenario);
  for (const ScenarioChange& change : changes) {
    WrittenValue value = change.value;
    if (value.plain && tree.takes_file(change.path))
      value = {read_file(folder / value.text, 16 << 20), false};
    tree.set(change.path, value);
  }
  return tree.scenario();
}

}  // namespace seam::app
