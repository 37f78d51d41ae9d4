// Keys of what was worked out from effects, for whoever keeps it.
#pragma once

#include "effects/model.h"

namespace seam::effects {

// An effect's name and its values to the last bit. Within one search a name means one effect.
std::string exact_key(const ModelEffect& effect);

}  // namespace seam::effects
