// What formulas of a model share: how a parameter is declared, how a text is written back.
#pragma once

#include <string>

#include "effects/effect.h"
#include "sim_core/base/config.h"

namespace seam::effects {

// A number, or a map of value, neutral, min, max, scale, help.
Parameter formula_parameter(const std::string& name, const ConfigNode& node);

std::string yaml_quoted(const std::string& text);

}  // namespace seam::effects
