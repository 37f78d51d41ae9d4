// A model as JSON, for programs that read no YAML.
#pragma once

#include <string>

#include "effects/model.h"

namespace seam::app {

// {"format": "seam-model/1", "name", "effects": {NAME: {PARAMETER: {"value", "sigma"?, "free"?,
// "spread"?}}}}; a value that is infinite stands as "inf" or "-inf".
std::string json_text(const effects::Model& model);

}  // namespace seam::app
