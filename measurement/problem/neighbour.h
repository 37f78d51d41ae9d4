// What tests of structure call the residual before, in time, of the same series.
#pragma once

namespace seam::measurement {

inline constexpr const char* kNeighbour = "neighbour";

}  // namespace seam::measurement
