#include "effects/cameras.h"

#include <algorithm>

#include "effects/questions.h"
#include "effects/registry.h"
#include "sim_core/base/error.h"

namespace seam::effects {

Model model_of(const Model& model, const std::string& camera) {
  Model own;
  for (const ModelEffect& effect : model.effects()) {
    const std::string& name = effect.definition->name;
    const std::string of = camera_of(name);
    if (of.empty()) {
      if (camera.empty() || !model.has(name + "@" + camera))
        own.set(effect.definition, effect.parameters);
    } else if (of == camera) {
      own.set(find_effect(plain_name(name)), effect.parameters);
    }
  }
  return own;
}

std::vector<std::string> cameras_with_lenses(const Model& model) {
  std::vector<std::string> cameras;
  if (has_base(model_of(model, ""), Base::projection)) cameras.emplace_back();
  for (const ModelEffect& effect : model.effects()) {
    const EffectDefinition& definition = *effect.definition;
    const std::string camera = camera_of(definition.name);
    const bool lens =
        definition.geometry || definition.image_map || definition.base == Base::projection;
    if (lens && !camera.empty() &&
        std::find(cameras.begin(), cameras.end(), camera) == cameras.end())
      cameras.push_back(camera);
  }
  return cameras;
}

std::string not_pictured(const EffectDefinition& effect) {
  if (!of_points_alone(effect)) return "";
  const auto said =
      std::find_if(effect.advice.begin(), effect.advice.end(),
                   [](const Advice& advice) { return (advice.kinds & kOutcomes) != 0; });
  return said == effect.advice.end() ? "" : said->text;
}

std::vector<std::string> not_pictured(const Model& model) {
  std::vector<std::string> sentences;
  for (const ModelEffect& effect : model.effects()) {
    const EffectDefinition& definition = *effect.definition;
    const std::string why = not_pictured(definition);
    const Values values = effect.values();
    const bool is_neutral = std::equal(
        values.begin(), values.end(), definition.parameters.begin(), definition.parameters.end(),
        [](double value, const Parameter& parameter) { return value == parameter.neutral; });
    if (!why.empty() && !is_neutral)
      sentences.push_back(fmt::format("no picture shows '{}': {}", definition.name, why));
  }
  return sentences;
}

void check_pictured(const Model& model) {
  const std::vector<std::string> sentences = not_pictured(model);
  if (!sentences.empty())
    throw InputError(fmt::format("model '{}': {}", model.name(), sentences.front()));
}

}  // namespace seam::effects
