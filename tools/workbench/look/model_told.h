// A model's effects as JSON, as the page reads them.
#pragma once

#include <nlohmann/json.hpp>

#include "effects/model.h"

namespace seam::tools {

// By effect and parameter: value, sigma (null where none was fitted) and whether it is free.
nlohmann::json effects_told(const effects::Model& model);

}  // namespace seam::tools
