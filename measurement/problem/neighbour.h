// What tests of structure call the residual before, in time, of the same series, and that of the
// next pixel of the same image.
#pragma once

namespace seam::measurement {

inline constexpr const char* kNeighbour = "neighbour";
inline constexpr const char* kPixelNeighbour = "neighbouring_pixel";

}  // namespace seam::measurement
