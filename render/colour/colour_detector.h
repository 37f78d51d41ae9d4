// What a colour detection table says of pixels. A pixel's byte carries one bit a channel, and may
// carry several.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "render/colour/colour_table.h"

namespace seam::render {

// Detections of one frame, one byte a pixel: `width_px` is half the frame's, down to a multiple of
// 8 (88 for 176 or 178), `height_px` half the frame's.
struct Detections {
  int width_px = 0;
  int height_px = 0;
  std::vector<uint8_t> bits;
};

// Of a frame of this size, in which nothing was detected.
Detections no_detections(int width_px, int height_px);

class ColourDetector {
 public:
  explicit ColourDetector(const ColourTable& table);

  uint8_t bits_of(uint8_t y, uint8_t cr, uint8_t cb) const {
    const Segment& segment = segments_[y / 8];
    return segment.of_cr[cr] & segment.of_cb[cb];
  }
  // Of a frame's interleaved Y, Cr, Cb; each output pixel is the mean of 2x2 (the imager's middle
  // layer), taken about the frame's centre.
  Detections detect(std::span<const uint8_t> ycrcb, int width_px, int height_px) const;

 private:
  // The channels in whose range each value is: a colour is in those of both its values.
  struct Segment {
    std::array<uint8_t, 256> of_cr{}, of_cb{};
  };
  std::array<Segment, kLumaSegments> segments_{};
};

}  // namespace seam::render
