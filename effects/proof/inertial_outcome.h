// Worked examples of stage `inertial` (proof.h).
#pragma once

#include "effects/model.h"
#include "effects/proof/quantities.h"

namespace seam::effects {

Quantities inertial_outcome(const Model& model, const Quantities& given);

}  // namespace seam::effects
