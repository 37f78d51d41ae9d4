#include "effects/schema/model_schema.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "effects/registry.h"

namespace seam::effects {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kUnbounded = 1e300;

Json bounded(const Parameter& parameter) {
  Json number = {{"type", parameter.integer ? "integer" : "number"}};
  if (std::abs(parameter.min) < kUnbounded) number["minimum"] = parameter.min;
  if (std::abs(parameter.max) < kUnbounded) number["maximum"] = parameter.max;
  const bool inside = parameter.neutral >= parameter.min && parameter.neutral <= parameter.max;
  if (inside || !std::isfinite(parameter.neutral)) return number;
  return {{"anyOf", {number, {{"const", parameter.neutral}}}}};
}

// A number, or a map with what a fit or a person says of it.
Json value_or_map(const Json& number, bool value_is_required) {
  Json map = {{"type", "object"}, {"additionalProperties", false}};
  if (value_is_required) map["required"] = {"value"};
  map["properties"] = {{"value", number},
                       {"sigma", {{"type", "number"}, {"minimum", 0}}},
                       {"free", {{"type", "boolean"}}},
                       {"spread", {{"type", "number"}, {"minimum", 0}}}};
  return {{"anyOf", {number, map}}};
}

Json effect_schema(const EffectDefinition& effect) {
  Json schema = {{"description", effect.help}, {"type", "object"}, {"additionalProperties", false}};
  Json required = Json::array(), properties = Json::object();
  for (const Parameter& parameter : effect.parameters) {
    if (parameter.required) required.push_back(parameter.name);
    properties[parameter.name] = value_or_map(bounded(parameter), true);
    properties[parameter.name]["description"] = parameter.help;
  }
  if (!required.empty()) schema["required"] = required;
  schema["properties"] = properties;
  return schema;
}

// An effect given by formulas; which outputs its stage has, the reader knows.
Json formula_schema() {
  const Json number = {{"type", "number"}};
  Json parameter = value_or_map(number, false);
  for (const char* key : {"neutral", "min", "max", "scale"})
    parameter["anyOf"][1]["properties"][key] = number;
  parameter["anyOf"][1]["properties"]["help"] = {{"type", "string"}};
  return {{"type", "object"},
          {"required", {"stage"}},
          {"properties",
           {{"stage", {{"type", "string"}}},
            {"help", {{"type", "string"}}},
            {"signature", {{"type", "string"}}},
            {"parameters", {{"type", "object"}, {"additionalProperties", parameter}}}}},
          {"additionalProperties", {{"type", {"string", "number"}}}}};
}

Json history_schema() {
  const Json text = {{"type", "string"}}, error = {{"type", "number"}, {"minimum", 0}};
  return {{"type", "array"},
          {"items",
           {{"type", "object"},
            {"additionalProperties", false},
            {"properties",
             {{"effect", text},
              {"parameters",
               {{"type", "object"},
                {"additionalProperties", value_or_map({{"type", "number"}}, true)}}},
              {"data_fingerprint", {{"type", {"string", "number"}}}},
              {"data", text},
              {"error_before", error},
              {"error_after", error}}}}}};
}

}  // namespace

std::string model_schema() {
  Json effects = Json::object();
  for (const auto& effect : catalogue()) effects[effect->name] = effect_schema(*effect);
  const Json schema = {
      {"$schema", "https://json-schema.org/draft/2020-12/schema"},
      {"title", "SEAM model"},
      {"type", "object"},
      {"additionalProperties", false},
      {"required", {"format", "effects"}},
      {"properties",
       {{"format", {{"const", "seam-model/1"}}},
        {"name", {{"description", "A short name."}, {"type", "string"}}},
        {"effects",
         {{"description", "Effects by name: of the catalogue, or with a stage and formulas."},
          {"type", "object"},
          {"properties", effects},
          {"patternProperties",
           {{"^[A-Za-z0-9_]+@[A-Za-z0-9_-]+$",
             {{"description", "An effect of one camera of several, by its name."},
              {"type", "object"},
              {"additionalProperties", value_or_map({{"type", "number"}}, true)}}}}},
          {"additionalProperties", formula_schema()}}},
        {"history", history_schema()}}}};
  return schema.dump(1) + "\n";
}

}  // namespace seam::effects
