#include "effects/formulas/scenario_effect.h"

#include <algorithm>

#include "effects/formulas/formula.h"
#include "effects/formulas/formula_parameter.h"
#include "sim_core/base/error.h"

namespace seam::effects {
namespace {

struct Setting {
  std::string path;
  Formula formula;
};

}  // namespace

std::shared_ptr<const EffectDefinition> scenario_effect(const std::string& name,
                                                        const ConfigNode& node) {
  auto effect = std::make_shared<EffectDefinition>();
  effect->name = name;
  effect->stage = Stage::scenario;
  effect->kinds = kOutcomes;
  effect->help = node.text_or("help", "A change of the scenario.");
  effect->signature = node.text_or("signature", "");
  effect->source = "    stage: " + to_string(Stage::scenario) + "\n";
  for (const auto& [key, text] :
       {std::pair("help", effect->help), {"signature", effect->signature}})
    if (node.has(key)) effect->source += fmt::format("    {}: {}\n", key, yaml_quoted(text));
  node.at("stage");
  std::vector<std::string> names;
  std::vector<double> neutral;
  const ConfigNode parameters = node.at("parameters");
  for (const std::string& key : parameter_keys(parameters)) {
    effect->parameters.push_back(formula_parameter(key, parameters.at(key)));
    neutral.push_back(effect->parameters.back().neutral);
    names.push_back(key);
  }
  if (names.empty()) parameters.fail("found none, expected one or more");
  const ConfigNode set = node.at("set");
  std::vector<Setting> settings;
  effect->source += "    set:\n";
  for (const std::string& path : set.keys()) {
    const ConfigNode text = set.at(path);
    try {
      settings.push_back({path, Formula(text.text(), names)});
    } catch (const InputError& error) {
      text.fail(error.what());
    }
    effect->source += fmt::format("      {}: {}\n", yaml_quoted(path),
                                  yaml_quoted(settings.back().formula.text()));
    effect->formula += (effect->formula.empty() ? "" : ", ") + path + " = " + text.text();
  }
  if (settings.empty()) set.fail("found no paths, expected keys of the scenario");
  node.finish();
  effect->scenario = [settings, neutral](Values p) {
    std::vector<std::pair<std::string, double>> changes;
    if (std::equal(p.begin(), p.end(), neutral.begin(), neutral.end())) return changes;
    for (const Setting& setting : settings) changes.emplace_back(setting.path, setting.formula(p));
    return changes;
  };
  return effect;
}

}  // namespace seam::effects
