#include "tools/workbench/look/model_told.h"

#include "measurement/report/finite_or_null.h"

namespace seam::tools {

nlohmann::json effects_told(const effects::Model& model) {
  using measurement::finite_or_null;
  using nlohmann::json;
  json effects = json::object();
  for (const effects::ModelEffect& effect : model.effects()) {
    json& parameters = effects[effect.definition->name] = json::object();
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const effects::ParameterValue& value = effect.parameters[i];
      parameters[effect.definition->parameters[i].name] = {
          {"value", finite_or_null<json>(value.value)},
          {"sigma", value.sigma ? finite_or_null<json>(*value.sigma) : json(nullptr)},
          {"free", value.free}};
    }
  }
  return effects;
}

}  // namespace seam::tools
