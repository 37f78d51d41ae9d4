#include "measurement/kinds/missed_channel.h"

#include <algorithm>

namespace seam::measurement {

void add_missed_channel(std::vector<Structure>& found, const std::string& channel,
                        const std::string& covariate, const ChannelMisfit& misfit, double p_value,
                        double known) {
  const auto is_known = [&](const Structure& s) {
    return s.residual == channel && s.p_value <= known;
  };
  if (p_value >= kMissed || std::any_of(found.begin(), found.end(), is_known)) return;
  found.push_back({.residual = channel,
                   .moment = "mean",
                   .covariate = covariate,
                   .strength = misfit.strength(),
                   .p_value = std::max(p_value, kLeastP)});
}

}  // namespace seam::measurement
