// What tests of structure call the residual before, in time, of the same series, and that of the
// next pixel of the same image; and what differs from run to run without any order.
#pragma once

namespace seam::measurement {

inline constexpr const char* kNeighbour = "neighbour";
inline constexpr const char* kPixelNeighbour = "neighbouring_pixel";
inline constexpr const char* kEachRun = "each_run";

}  // namespace seam::measurement
