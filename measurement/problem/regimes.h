// The split into training and held-out groups, by what inputs show: what no group that is fitted
// shows the fit cannot know, and what none that is held out shows nothing tests.
#pragma once

#include <string>
#include <vector>

#include "measurement/problem/facts.h"

namespace seam::measurement {

// The ceil(0.3 G) with the smallest hash of their name are held out, but as many of them exchanged
// for others as it takes that of each regime, by the groups that show it, one trains and, of two or
// more, one is held out. Where not all can be met, those of training go first.
Groups held_out_of_each(const std::vector<std::string>& names, const std::vector<Groups>& regimes);

// A regime for each label and each sign of the set's inputs.
std::vector<Groups> regimes_of_labels(const Facts& facts);

}  // namespace seam::measurement
