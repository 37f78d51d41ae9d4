// What a fit is of, for whoever keeps its outcome.
#pragma once

#include <string>
#include <vector>

#include "measurement/problem/problem.h"

namespace seam::measurement {

// The groups, the model's values to the last bit, and which of them are sought.
std::string fit_key(const Model& model, const std::vector<Unknown>& unknowns, const Groups& groups);

}  // namespace seam::measurement
