// What formulas of a model share: how a parameter is declared, how a text is written back.
#pragma once

#include <string>
#include <vector>

#include "effects/effect.h"
#include "sim_core/base/config.h"

namespace seam::effects {

// Variables, columns and parameters of a formula, together.
inline constexpr size_t kMostInputs = 64;

// The names of an effect's parameters; fails where there are more, before any is read.
std::vector<std::string> parameter_keys(const ConfigNode& parameters);

// A number, or a map of value, neutral, min, max, scale, help.
Parameter formula_parameter(const std::string& name, const ConfigNode& node);

std::string yaml_quoted(const std::string& text);

}  // namespace seam::effects
