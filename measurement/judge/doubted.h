// What speaks against an effect that was named, however much it gains: a value where its range
// ends, effects that need each other to cancel, values that a single group makes.
#pragma once

#include <string>
#include <vector>

#include "measurement/fitting/assess.h"

namespace seam::measurement {

// Whether the value lies at an end of its range other than neutral.
bool is_at_bound(const effects::Parameter& parameter, double value);

// Whether the model can be without this effect while all else stays: no base, nothing in the place
// of another, nothing that comes with others or that others need.
bool can_be_missed(const Model& model, const std::string& effect);

// By named effect of the model why it is no cause established; empty where nothing speaks against
// it. The errors of `best` are those that are stated.
std::vector<std::vector<std::string>> doubts_of(const Problem& problem, const Assessment& best,
                                                const std::vector<std::string>& named);

}  // namespace seam::measurement
