// What a worked example gives and expects, by name.
#pragma once

#include <string>
#include <vector>

#include "effects/answers.h"

namespace seam::effects {

using Quantities = std::vector<Quantity>;

inline double value_of(const Quantities& list, const std::string& name, double otherwise = 0) {
  for (const Quantity& quantity : list) {
    if (quantity.name == name) return quantity.value;
  }
  return otherwise;
}

}  // namespace seam::effects
