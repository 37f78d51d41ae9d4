// Kinds of few numbers, in no order that a test of structure could find: that a channel misses by
// more than its errors is a structure of its own.
#pragma once

#include <string>
#include <vector>

#include "measurement/problem/channel_misfit.h"

namespace seam::measurement {

// Below it a structure is significant.
inline constexpr double kMissed = 1e-3;

// Adds the misfit to the structures found where its `p_value` is significant and none of those has
// the channel with a p value of at most `known`.
void add_missed_channel(std::vector<Structure>& found, const std::string& channel,
                        const std::string& covariate, const ChannelMisfit& misfit, double p_value,
                        double known);

}  // namespace seam::measurement
