#include "render/colour/colour_space.h"

#include <algorithm>

#include "sim_core/base/error.h"

namespace seam::render {
namespace {

uint8_t to_byte(int value) {
  return static_cast<uint8_t>(std::clamp(value, 0, 255));
}

// Rounded division by 100, halves away from zero.
int hundredths(int value) {
  return (value >= 0 ? value + 50 : value - 50) / 100;
}

}  // namespace

void rgb_to_ycrcb(std::span<const uint8_t> rgb, std::span<uint8_t> ycrcb) {
  SEAM_CHECK(rgb.size() == ycrcb.size() && rgb.size() % 3 == 0, "{} {}", rgb.size(), ycrcb.size());
  for (size_t i = 0; i < rgb.size(); i += 3) {
    const int r = rgb[i], g = rgb[i + 1], b = rgb[i + 2];
    const int y = (51 * r + 100 * g + 19 * b + 85) / 170;
    ycrcb[i] = static_cast<uint8_t>(y);
    ycrcb[i + 1] = to_byte(r - y + 128);
    ycrcb[i + 2] = to_byte(b - y + 128);
  }
}

void ycrcb_to_rgb(std::span<const uint8_t> ycrcb, std::span<uint8_t> rgb) {
  SEAM_CHECK(rgb.size() == ycrcb.size() && rgb.size() % 3 == 0, "{} {}", rgb.size(), ycrcb.size());
  for (size_t i = 0; i < rgb.size(); i += 3) {
    const int y = ycrcb[i], cr = ycrcb[i + 1] - 128, cb = ycrcb[i + 2] - 128;
    rgb[i] = to_byte(y + cr);
    rgb[i + 1] = to_byte(y - hundredths(51 * cr + 19 * cb));
    rgb[i + 2] = to_byte(y + cb);
  }
}

}  // namespace seam::render
