// One sigma that a set may state, in the unit of its column, and a row's weight: no sensor of
// metres, radians, pixels or counts is better or worse.
#pragma once

namespace seam::measurement {

inline constexpr double kLeastNoise = 1e-12, kMostNoise = 1e12;

}  // namespace seam::measurement
