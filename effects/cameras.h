// Several cameras on one rig: what a model says of each.
#pragma once

#include <string>
#include <vector>

#include "effects/model.h"

namespace seam::effects {

// What of a model acts on one camera: its own effects before those of all, under plain names.
Model model_of(const Model& model, const std::string& camera);

// The cameras that have a lens of their own, in the model's order, and an empty name before them
// where the model has a lens for all others.
std::vector<std::string> cameras_with_lenses(const Model& model);

}  // namespace seam::effects
