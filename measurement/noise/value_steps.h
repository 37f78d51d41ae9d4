// The step of values that were rounded to multiples of one, whatever the digits in which a file has
// them: a step of 2 pi / 4096 rad, logged in degrees with 4 decimals, is no multiple of a last
// digit.
#pragma once

#include <vector>

namespace seam::measurement {

// The largest step on whose multiples, from an offset of each series' own, nearly all values lie;
// 0: none. Found from the distribution of differences: their phases over the step agree (the
// periodogram of a comb, Rayleigh's test).
double step_of_values(const std::vector<std::vector<double>>& series);

}  // namespace seam::measurement
