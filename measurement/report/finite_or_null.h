// Numbers in JSON, which has no infinities.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

namespace seam::measurement {

// Null where a number does not exist.
template <typename Json>
Json finite_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

}  // namespace seam::measurement
