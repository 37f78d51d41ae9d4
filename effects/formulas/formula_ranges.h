// A model's formulas tried over the ranges of what they read, before any run meets the place where
// one of them gives no number.
#pragma once

#include <string>
#include <vector>

#include "effects/model.h"

namespace seam::effects {

struct FormulaTrouble {
  std::string text;      // "effects.x: q = nan at q = 0.5, rate = -2 ..., with k = 1".
  bool certain = false;  // With the model's own values; else with others that its bounds allow.
};

// At most one finding of each sort an effect.
std::vector<FormulaTrouble> troubles_of_formulas(const Model& model);

}  // namespace seam::effects
