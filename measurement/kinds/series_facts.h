// Facts that sets of runs have in common: servo logs, walks.
#pragma once

#include <vector>

#include "measurement/problem/facts.h"
#include "measurement/sets/set.h"

namespace seam::measurement {

// Title, groups, lines and scalars of a table of observations with so many channels a row; times
// and series follow by add_series.
void describe_rows(const MeasurementSet& set, const CsvTable& table, int channels, Facts& facts);

// The rows of series `number` with their times. Throws InputError where they are of several groups.
void add_series(const MeasurementSet& set, const CsvTable& table, size_t number,
                const std::vector<size_t>& rows, const std::vector<double>& time_s, Facts& facts);

}  // namespace seam::measurement
