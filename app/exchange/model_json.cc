#include "app/exchange/model_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace seam::app {
namespace {

// JSON has no infinities.
nlohmann::ordered_json number(double value) {
  if (std::isfinite(value)) return value;
  return value > 0 ? "inf" : "-inf";
}

}  // namespace

std::string json_text(const effects::Model& model) {
  nlohmann::ordered_json all = {{"format", "seam-model/1"}, {"name", model.name()}};
  all["effects"] = nlohmann::ordered_json::object();
  for (const effects::ModelEffect& effect : model.effects()) {
    nlohmann::ordered_json& values = all["effects"][effect.definition->name];
    values = nlohmann::ordered_json::object();
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const effects::ParameterValue& given = effect.parameters[i];
      nlohmann::ordered_json& value = values[effect.definition->parameters[i].name];
      value["value"] = number(given.value);
      if (given.sigma) value["sigma"] = number(*given.sigma);
      if (given.free) value["free"] = true;
      if (given.spread != 0) value["spread"] = number(given.spread);
    }
  }
  return all.dump(2) + "\n";
}

}  // namespace seam::app
