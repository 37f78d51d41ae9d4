#include "render/colour/colour_detector.h"

#include "sim_core/base/error.h"

namespace seam::render {

ColourDetector::ColourDetector(const ColourTable& table) {
  for (int channel = 0; channel < kColourChannels; ++channel) {
    const auto bit = static_cast<uint8_t>(1u << channel);
    for (int luma = 0; luma < kLumaSegments; ++luma) {
      const ColourRange& range = table.channel(channel)[luma];
      for (int cr = range.cr_min; cr <= range.cr_max; ++cr) segments_[luma].of_cr[cr] |= bit;
      for (int cb = range.cb_min; cb <= range.cb_max; ++cb) segments_[luma].of_cb[cb] |= bit;
    }
  }
}

Detections no_detections(int width_px, int height_px) {
  Detections none{.width_px = width_px >= 16 ? width_px / 2 / 8 * 8 : width_px / 2,
                  .height_px = height_px / 2,
                  .bits = {}};
  none.bits.resize(static_cast<size_t>(none.width_px) * none.height_px);
  return none;
}

Detections ColourDetector::detect(std::span<const uint8_t> ycrcb, int width_px,
                                  int height_px) const {
  SEAM_CHECK(ycrcb.size() == static_cast<size_t>(width_px) * height_px * 3, "{}", ycrcb.size());
  Detections out = no_detections(width_px, height_px);
  const int left = (width_px - 2 * out.width_px) / 2, top = (height_px - 2 * out.height_px) / 2;
  for (int v = 0; v < out.height_px; ++v) {
    const uint8_t* above = &ycrcb[3 * (static_cast<size_t>(top + 2 * v) * width_px + left)];
    const uint8_t* below = above + 3 * static_cast<size_t>(width_px);
    for (int u = 0; u < out.width_px; ++u, above += 6, below += 6) {
      const auto mean = [&](int c) {
        return static_cast<uint8_t>((above[c] + above[c + 3] + below[c] + below[c + 3] + 2) / 4);
      };
      out.bits[static_cast<size_t>(v) * out.width_px + u] = bits_of(mean(0), mean(1), mean(2));
    }
  }
  return out;
}

}  // namespace seam::render
