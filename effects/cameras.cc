#include "effects/cameras.h"

#include <algorithm>

#include "effects/questions.h"
#include "effects/registry.h"

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

}  // namespace seam::effects
