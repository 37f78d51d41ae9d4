// A motor's drag may sit behind its saturation (back-EMF, viscous friction) or before it (the
// damping of its own controller, or back-EMF within a limit of torque): the same while nothing
// saturates, and a valley apart where something does.
#pragma once

#include <optional>
#include <vector>

#include "effects/model.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {

// The model with shares of its drag moved into the controller, whose duty cuts off the drive where
// the model did. Empty where it has no motor, or no drag.
std::vector<effects::Model> damped_otherwise(const effects::Model& model);

// The same of a model whose drive a limit of torque cuts off, which then goes; empty where none
// does.
std::vector<effects::Model> damped_within_limit(const effects::Model& model);

// Back-EMF within a limit of torque and viscous friction outside it, as the damping of a controller
// whose duty saturates there and the motor's own back-EMF: the same motion as long as the torque is
// on. None where the model has no such two.
std::optional<effects::Model> damped_alike(const effects::Model& model);

// A drag on both sides of one saturation as that of a stronger motor alone, whose duty and whose
// limit of torque both cut off the drive: what lies between the two moves much alike. Empty where
// the controller has no damping, or the model no such limit to set.
std::vector<effects::Model> limited_otherwise(const effects::Model& model);

// The same drag as back-EMF alone. None where the model's controller has no damping, or one that is
// not to be fitted.
std::optional<effects::Model> undamped(const effects::Model& model,
                                       const std::vector<Unknown>& unknowns);

// Whether a fit left the motor a share of the drag, or a small one that is clearly not 0. One whose
// controller has it all is a motor with back-EMF behind a limit of torque, by another name.
bool keeps_back_emf(const Fit& fit, const std::vector<Unknown>& unknowns);

}  // namespace seam::measurement
