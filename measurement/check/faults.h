// Faults that data of any laboratory may have, told by name from the tables alone, before a model
// is held against them: units, clocks, columns exchanged, frames that were stored twice. Each has
// its evidence in the sentence. The numbers behind them are far from what effects do to good data.
#pragma once

#include <string>
#include <vector>

#include "measurement/sets/set.h"

namespace seam::measurement {

// Of the values measured, each "of what: sentence"; empty where nothing is odd.
std::vector<std::string> faults_of_values(const MeasurementSet& set);

// Of the clocks: steps that are no seconds, jumps, logs that do not cover the observations.
std::vector<std::string> faults_of_clocks(const MeasurementSet& set);

}  // namespace seam::measurement
