// A model: which effects are present, with which parameter values, and how it came about.
// File format `seam-model/1` (docs/reference/models.md).
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "effects/effect.h"

namespace seam {
class ConfigNode;
struct RandomStream;
}  // namespace seam

namespace seam::effects {

struct ParameterValue {
  double value = 0;
  std::optional<double>
      sigma;          // Fitted earlier, with this standard deviation: refitted in comparisons.
  bool free = false;  // A nuisance: refitted in every comparison.
  double spread = 0;  // Individual robots differ by this much (one sigma).

  bool refitted() const { return free || sigma.has_value(); }
};

struct ModelEffect {
  std::shared_ptr<const EffectDefinition> definition;
  std::vector<ParameterValue> parameters;  // As many, and in the order, as the definition declares.

  // The plain values, valid while this object is not changed.
  Values values() const { return values_; }
  double value(const std::string& parameter) const;
  void set(size_t parameter, const ParameterValue& value);

 private:
  friend class Model;
  std::vector<double> values_;
  void refresh();
};

// One step of a model's history: an effect was added (or the model was refitted).
struct HistoryStep {
  std::string effect;  // Empty for a plain refit.
  std::vector<std::pair<std::string, ParameterValue>> parameters;
  std::string data_fingerprint;
  std::string data;  // The set's title.
  double error_before = 0;
  double error_after = 0;
};

class Model {
 public:
  static Model from_file(const std::filesystem::path& path);
  static Model from_config(const ConfigNode& root);
  std::string to_yaml() const;
  void write(const std::filesystem::path& path) const;

  const std::string& name() const { return name_; }
  void set_name(std::string name) { name_ = std::move(name); }

  // In the order of composition: the catalogue's, then plugins, then expressions.
  const std::vector<ModelEffect>& effects() const { return effects_; }
  const ModelEffect* find(const std::string& effect) const;
  bool has(const std::string& effect) const { return find(effect) != nullptr; }

  // Adds the effect, or replaces its values. `values` as the definition declares them.
  void set(std::shared_ptr<const EffectDefinition> definition, std::vector<ParameterValue> values);
  // Adds it at neutral values.
  void add_neutral(std::shared_ptr<const EffectDefinition> definition);
  void remove(const std::string& effect);
  // One parameter of an effect that is present.
  void set_value(const std::string& effect, size_t parameter, double value);

  const std::vector<HistoryStep>& history() const { return history_; }
  void append_history(HistoryStep step) { history_.push_back(std::move(step)); }

  // This model with individual values drawn from the stated spreads (each robot's difference).
  Model individual(RandomStream robot) const;

 private:
  std::string name_;
  std::vector<ModelEffect> effects_;
  std::vector<HistoryStep> history_;
};

// Effects defined by expressions in a YAML map of name to definition (expression.cc).
std::shared_ptr<const EffectDefinition> expression_effect(const std::string& name,
                                                          const ConfigNode& node);
// The values that the same node gives to its parameters.
std::vector<ParameterValue> expression_values(const EffectDefinition& definition,
                                              const ConfigNode& node);
// The YAML of an expression effect's definition without its values; empty for catalogue effects.
std::string expression_source(const EffectDefinition& definition);

}  // namespace seam::effects
