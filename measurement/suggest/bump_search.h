// The strongest bump in scattered observations of a variable.
#pragma once

#include <optional>
#include <vector>

#include "measurement/suggest/wave_search.h"

namespace seam::measurement {

struct FoundBump {
  double place = 0, width = 0;
};

// weight * amplitude * exp(-((at - place) / width)^2) takes the most of `rest`, an observation
// each, of some places and widths; nothing where observations are few or the variable stays.
std::optional<FoundBump> strongest_bump(const std::vector<double>& at,
                                        const std::vector<double>& weight,
                                        const std::vector<double>& rest,
                                        const Arrives& arrives = {});

}  // namespace seam::measurement
