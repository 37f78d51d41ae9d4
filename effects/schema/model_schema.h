// JSON Schema of models (docs/reference/schemas/model.schema.json): the effects of the catalogue
// with the parameters and bounds that the reader of models takes them by.
#pragma once

#include <string>

namespace seam::effects {

std::string model_schema();

}  // namespace seam::effects
