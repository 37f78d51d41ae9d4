// A scenario as a tree of keys with everything in it that it names by file, so that any key of
// scenario, robot, field or model changes by its path: `duration_s`, `robots[0].pose.x_m`,
// `robots[red1].camera.model.effects.EFFECT.PARAMETER`, `robots[*].camera.every_frame`.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "sim_core/scenario/scenario.h"

namespace YAML {
class Node;
}

namespace seam::app {

// A value as a person writes it: a plain word or number, or the YAML text of a list or a map.
struct WrittenValue {
  std::string text;
  bool plain = true;
  bool operator==(const WrittenValue&) const = default;
};

// Nothing where it is no number.
std::optional<double> number_of(const WrittenValue& value);

// One change of a scenario, as it was asked for.
struct ScenarioChange {
  std::string path;
  WrittenValue value;
};

// "PATH=VALUE", as `--set` takes it. Throws UsageError where it is not of this form.
ScenarioChange change_from_text(const std::string& text);

class ScenarioTree {
 public:
  explicit ScenarioTree(const Scenario& scenario);
  // `yaml` as Scenario::to_yaml writes it; `name` stands in messages.
  ScenarioTree(const std::string& yaml, const std::string& name);
  ScenarioTree(const ScenarioTree& other);  // A tree of its own.
  ScenarioTree(ScenarioTree&&) noexcept;
  ScenarioTree& operator=(const ScenarioTree&) = delete;
  ~ScenarioTree();

  // Throws InputError with the nearest known key where the path leads nowhere. Inside a model,
  // effects and parameters that it does not state may be named: the model's reader knows them. Of
  // a value with its uncertainty or spread, `{value: 3, spread: 0.1}`, a number changes the value.
  void set(const std::string& path, const WrittenValue& value);
  // Whether a plain value at this path is the name of a file (of a model, robot, field or colour
  // table), whose content is to be set in its place. Throws as `set` does.
  bool takes_file(const std::string& path) const;
  // The scenario with all changes, checked as any scenario is.
  Scenario scenario() const;

 private:
  std::string name_;
  std::unique_ptr<YAML::Node> root_;
};

// Makes all changes; files are looked for beside `folder`.
Scenario changed_scenario(const Scenario& scenario, const std::vector<ScenarioChange>& changes,
                          const std::filesystem::path& folder);

}  // namespace seam::app
