// Which steps of an analogue-to-digital converter the values of images allow.
#pragma once

#include <cstdint>
#include <vector>

namespace seam::measurement {

// The fewest bits that a converter of these values can have had: all of them but strays (1 %) are
// multiples of its step 2^(file_bits - bits), or stand at the file's highest value. `file_bits`
// where none is coarser than the file.
int fewest_bits(const std::vector<std::vector<uint16_t>>& images, int file_bits);

}  // namespace seam::measurement
