// Draws errors that hang together (`seam measure`).
#pragma once

#include <vector>

#include "effects/stages/noise.h"
#include "sim_core/base/random.h"

namespace seam::measurement {

// Adds an error that wanders to the values of these rows. `rows` are the track's; they are taken in
// order of time, and each draws the number of its row, so that a track is the same whatever else is
// drawn.
void add_wander(const effects::Wander& wander, const std::vector<double>& time_s,
                std::vector<size_t> rows, RandomStream stream, std::vector<double>& values);

}  // namespace seam::measurement
