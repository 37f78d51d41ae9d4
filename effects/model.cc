#include "effects/model.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

#include "effects/effect_keys.h"
#include "effects/questions.h"
#include "effects/registry.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::effects {
namespace {

// Before anything that is missing: the unknown name may be the one that is missed.
void refuse_unknown(const ConfigNode& node, const char* what,
                    const std::vector<std::string>& known) {
  for (const std::string& key : node.keys()) {
    if (std::find(known.begin(), known.end(), key) == known.end())
      node.fail(fmt::format("unknown {} '{}'{}", what, key, suggestion_for(key, known)));
  }
}

ParameterValue read_value(const ConfigNode& node, const Parameter& parameter) {
  ParameterValue value;
  if (node.is_map()) {
    refuse_unknown(node, "key", {"value", "sigma", "free", "spread"});
    value.value = node.at("value").number();
    if (const auto sigma = node.find("sigma")) value.sigma = sigma->number({0, 1e300});
    value.free = node.boolean_or("free", false);
    value.spread = node.number_or("spread", 0, {0, 1e300});
    node.finish();
  } else {
    value.value = node.number();
  }
  const bool in_bounds = value.value >= parameter.min && value.value <= parameter.max;
  if (!in_bounds && value.value != parameter.neutral) {
    node.fail(fmt::format("found {}, expected {} from {} to {}", value.value, parameter.name,
                          parameter.min, parameter.max));
  }
  if (parameter.integer && value.value != std::floor(value.value)) {
    node.fail(fmt::format("found {}, expected a whole number", value.value));
  }
  return value;
}

std::vector<ParameterValue> read_parameters(const ConfigNode& node,
                                            const EffectDefinition& effect) {
  std::vector<std::string> names;
  for (const Parameter& parameter : effect.parameters) names.push_back(parameter.name);
  refuse_unknown(node, "parameter", names);
  std::vector<ParameterValue> values;
  for (const Parameter& parameter : effect.parameters) {
    const auto given = node.find(parameter.name);
    if (!given && parameter.required)
      node.fail(fmt::format("parameter '{}' is missing", parameter.name));
    values.push_back(given ? read_value(*given, parameter)
                           : ParameterValue{.value = parameter.neutral});
  }
  node.finish();
  return values;
}

std::string number_text(double value) {
  return fmt::format("{}", value);
}

std::string value_text(const ParameterValue& value) {
  if (!value.sigma && !value.free && value.spread == 0) return number_text(value.value);
  std::string text = "{value: " + number_text(value.value);
  if (value.sigma) text += ", sigma: " + number_text(*value.sigma);
  if (value.free) text += ", free: true";
  if (value.spread != 0) text += ", spread: " + number_text(value.spread);
  return text + "}";
}

std::string quoted(const std::string& text) {
  YAML::Emitter out;
  out << YAML::DoubleQuoted << text;
  return out.c_str();
}

// A name of a formula or of its parameter as a key of YAML, in quotes where it is no plain word.
std::string key_text(const std::string& name) {
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  };
  const bool plain = !name.empty() && is_letter(name.front()) &&
                     std::all_of(name.begin(), name.end(), [&](char c) {
                       return is_letter(c) || (c >= '0' && c <= '9') || c == '-' || c == '@';
                     });
  return plain ? name : quoted(name);
}

size_t place_of(const EffectDefinition& definition) {
  const auto& all = catalogue();
  for (size_t i = 0; i < all.size(); ++i) {
    if (all[i]->name == plain_name(definition.name)) return i;
  }
  return all.size();
}

HistoryStep read_history_step(const ConfigNode& node) {
  HistoryStep step;
  step.effect = node.text_or("effect", "");
  if (const auto parameters = node.find("parameters")) {
    for (const std::string& key : parameters->keys()) {
      step.parameters.emplace_back(
          key,
          read_value(parameters->at(key), Parameter{.name = key, .min = -1e300, .max = 1e300}));
    }
  }
  step.data_fingerprint = node.text_or("data_fingerprint", "");
  step.data = node.text_or("data", "");
  step.error_before = node.number_or("error_before", 0, {0, 1e300});
  step.error_after = node.number_or("error_after", 0, {0, 1e300});
  node.finish();
  return step;
}

}  // namespace

void ModelEffect::refresh() {
  values_.clear();
  for (const ParameterValue& parameter : parameters) values_.push_back(parameter.value);
}

void ModelEffect::set(size_t parameter, const ParameterValue& value) {
  parameters.at(parameter) = value;
  values_.at(parameter) = value.value;
}

double ModelEffect::value(const std::string& parameter) const {
  for (size_t i = 0; i < parameters.size(); ++i) {
    if (definition->parameters[i].name == parameter) return parameters[i].value;
  }
  SEAM_CHECK(false, "{} has no parameter {}", definition->name, parameter);
}

Model Model::from_file(const std::filesystem::path& path) {
  return from_config(ConfigNode::from_file(path));
}

Model Model::from_config(const ConfigNode& root) {
  Model model;
  root.at("format").choice({"seam-model/1"});
  model.name_ = root.text_or("name", "unnamed");
  const ConfigNode effects = root.at("effects");
  for (const std::string& name : effect_keys(effects)) {
    const ConfigNode node = effects.at(name);
    if (node.is_map() && node.has("stage")) {
      const auto definition = expression_effect(name, node);
      std::vector<ParameterValue> values = expression_values(*definition, node);
      model.set(definition, std::move(values));
      continue;
    }
    const auto definition = find_effect(name);
    if (!definition)
      effects.fail(
          fmt::format("unknown effect '{}'{}", name, suggestion_for(name, effect_names())));
    model.set(definition, read_parameters(node, *definition));
  }
  if (const auto history = root.find("history")) {
    for (const ConfigNode& step : history->items())
      model.history_.push_back(read_history_step(step));
  }
  root.finish();
  if (const std::string conflict = conflict_in(model); !conflict.empty()) effects.fail(conflict);
  return model;
}

std::string Model::to_yaml() const {
  std::string out = "format: seam-model/1\nname: " + quoted(name_) + "\neffects:";
  if (effects_.empty()) out += " {}";
  out += "\n";
  for (const ModelEffect& effect : effects_) {
    const EffectDefinition& definition = *effect.definition;
    const std::string source = expression_source(definition);
    if (!source.empty()) {
      out += "  " + key_text(definition.name) + ":\n" + source + "    parameters:\n";
      for (size_t i = 0; i < effect.parameters.size(); ++i) {
        const Parameter& parameter = definition.parameters[i];
        const ParameterValue& value = effect.parameters[i];
        out += fmt::format("      {}: {{value: {}, neutral: {}, min: {}, max: {}",
                           key_text(parameter.name), value.value, parameter.neutral, parameter.min,
                           parameter.max);
        if (value.sigma) out += ", sigma: " + number_text(*value.sigma);
        if (value.free) out += ", free: true";
        if (value.spread != 0) out += ", spread: " + number_text(value.spread);
        out += "}\n";
      }
      continue;
    }
    out += "  " + definition.name + ": {";
    bool first = true;
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      // An infinite limit is absent; YAML files of ours hold finite numbers only.
      if (!std::isfinite(effect.parameters[i].value)) continue;
      out += (first ? "" : ", ") + definition.parameters[i].name + ": " +
             value_text(effect.parameters[i]);
      first = false;
    }
    out += "}\n";
  }
  if (!history_.empty()) out += "history:\n";
  for (const HistoryStep& step : history_) {
    out += "  - effect: " + quoted(step.effect) + "\n    parameters: {";
    bool first = true;
    for (size_t i = 0; i < step.parameters.size(); ++i) {
      if (!std::isfinite(step.parameters[i].second.value)) continue;
      out += (first ? "" : ", ") + key_text(step.parameters[i].first) + ": " +
             value_text(step.parameters[i].second);
      first = false;
    }
    out += "}\n    data: " + quoted(step.data) +
           "\n    data_fingerprint: " + quoted(step.data_fingerprint);
    out += "\n    error_before: " + number_text(step.error_before) +
           "\n    error_after: " + number_text(step.error_after) + "\n";
  }
  return out;
}

void Model::write(const std::filesystem::path& path) const {
  write_file_atomically(path, to_yaml());
}

const ModelEffect* Model::find(const std::string& effect) const {
  const auto found = std::find_if(effects_.begin(), effects_.end(), [&](const ModelEffect& e) {
    return e.definition->name == effect;
  });
  return found == effects_.end() ? nullptr : &*found;
}

void Model::set(std::shared_ptr<const EffectDefinition> definition,
                std::vector<ParameterValue> values) {
  SEAM_CHECK(values.size() == definition->parameters.size(), "{}", definition->name);
  remove(definition->name);
  ModelEffect effect;
  effect.definition = std::move(definition);
  effect.parameters = std::move(values);
  effect.refresh();
  const size_t place = place_of(*effect.definition);
  const auto behind = std::find_if(effects_.begin(), effects_.end(), [&](const ModelEffect& other) {
    return place_of(*other.definition) > place;
  });
  effects_.insert(behind, std::move(effect));
}

void Model::add_neutral(std::shared_ptr<const EffectDefinition> definition) {
  std::vector<ParameterValue> values;
  for (const Parameter& parameter : definition->parameters)
    values.push_back({.value = parameter.neutral});
  set(std::move(definition), std::move(values));
}

void Model::remove(const std::string& effect) {
  std::erase_if(effects_, [&](const ModelEffect& e) { return e.definition->name == effect; });
}

void Model::set_value(const std::string& effect, size_t parameter, double value) {
  for (ModelEffect& e : effects_) {
    if (e.definition->name != effect) continue;
    ParameterValue changed = e.parameters.at(parameter);
    changed.value = value;
    e.set(parameter, changed);
    return;
  }
  SEAM_CHECK(false, "the model has no {}", effect);
}

Model Model::individual(RandomStream robot) const {
  Model drawn = *this;
  for (ModelEffect& effect : drawn.effects_) {
    const RandomStream stream = robot.child(effect.definition->name);
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      ParameterValue value = effect.parameters[i];
      if (value.spread == 0) continue;
      const Parameter& parameter = effect.definition->parameters[i];
      value.value =
          std::clamp(value.value + value.spread * normal(stream, i), parameter.min, parameter.max);
      value.spread = 0;
      effect.set(i, value);
    }
  }
  return drawn;
}

}  // namespace seam::effects
