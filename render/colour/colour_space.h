// OPEN-R's colour space: R = Y + Cr, G = Y - 0.51 Cr - 0.19 Cb, B = Y + Cb (the OPEN-R sample
// code).
#pragma once

#include <cstdint>
#include <span>

namespace seam::render {

// Interleaved R, G, B to interleaved Y, Cr, Cb, each a byte. The differences are stored with 128
// for zero and clipped to a byte (they span +-179). Y = (0.51 R + G + 0.19 B) / 1.70, rounded.
void rgb_to_ycrcb(std::span<const uint8_t> rgb, std::span<uint8_t> ycrcb);

// The robot's own formula, clipped to bytes.
void ycrcb_to_rgb(std::span<const uint8_t> ycrcb, std::span<uint8_t> rgb);

}  // namespace seam::render
