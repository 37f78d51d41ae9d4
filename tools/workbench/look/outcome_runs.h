// What whole runs of the simulator kept, of sets of kind outcomes: distributions for a page.
#pragma once

#include <string>

#include "measurement/problem/problem.h"

namespace seam::tools {

// A head {scenarios: [{name, values, runs}]}, then for each value of each scenario one 32-bit float
// a run, as this model predicts them. Empty where the set is of another kind.
std::string predicted_runs(const measurement::Problem& problem, const measurement::Model& model);

}  // namespace seam::tools
