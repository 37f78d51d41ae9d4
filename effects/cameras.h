// Cameras: what a model says of each where several are on one rig, and what of it no picture shows.
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

// Why no picture shows an effect of points alone, and what to use instead: its advice for the kind
// of runs, in which it has no part. Empty where it gives none, as those of targets and detectors.
std::string not_pictured(const EffectDefinition& effect);

// The same of what the model has of such effects beside their neutral values, a sentence each.
std::vector<std::string> not_pictured(const Model& model);

// Throws InputError with the first of these: pictures would be as if it were not there.
void check_pictured(const Model& model);

}  // namespace seam::effects
