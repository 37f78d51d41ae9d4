#include "effects/formulas/formula_parameter.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "sim_core/base/error.h"

namespace seam::effects {

std::vector<std::string> parameter_keys(const ConfigNode& parameters) {
  std::vector<std::string> keys = parameters.keys();
  if (keys.size() > kMostInputs)
    parameters.fail(
        fmt::format("found {} parameters, expected {} at most", keys.size(), kMostInputs));
  return keys;
}

Parameter formula_parameter(const std::string& name, const ConfigNode& node) {
  Parameter parameter{.name = name, .min = -1e6, .max = 1e6, .scale = 0};
  if (node.is_map()) {
    parameter.neutral = node.number_or("neutral", 0, {-1e300, 1e300});
    parameter.min = node.number_or("min", parameter.min, {-1e300, 1e300});
    parameter.max = node.number_or("max", parameter.max, {-1e300, 1e300});
    parameter.scale = node.number_or("scale", 0, {0, 1e300});
    parameter.help = node.text_or("help", "");
    if (!(parameter.min < parameter.max)) node.fail("expected min below max");
    for (const char* key : {"value", "sigma", "free", "spread"}) node.has(key);
    node.finish();
  }
  // A tenth of the stated range is a typical size; a range that nobody stated says nothing.
  if (parameter.scale == 0) parameter.scale = std::min(0.1 * (parameter.max - parameter.min), 1.0);
  return parameter;
}

std::string yaml_quoted(const std::string& text) {
  YAML::Emitter out;
  out << YAML::DoubleQuoted << text;
  return out.c_str();
}

}  // namespace seam::effects
