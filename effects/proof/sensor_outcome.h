// Worked examples of stage `sensor` (proof.h).
#pragma once

#include "effects/model.h"
#include "effects/proof/quantities.h"

namespace seam::effects {

Quantities sensor_outcome(const Model& model, const Quantities& given);

}  // namespace seam::effects
