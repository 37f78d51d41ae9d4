// Connected regions of one colour in a colour-detection image.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace seam::sdk {

// The channels of the robot's colour detection table; each is one bit of a pixel, and a pixel can
// carry several.
enum class Colour : uint8_t { orange, yellow, skyblue, pink, green, carpet, red, darkblue };

// One byte a pixel, bit c set where the pixel has colour c. Row-major; borrowed.
struct ColourMask {
  int width_px = 0;
  int height_px = 0;
  std::span<const uint8_t> bits;

  bool has(int u, int v, Colour colour) const {
    return (bits[static_cast<size_t>(v) * width_px + u] >> static_cast<int>(colour) & 1) != 0;
  }
};

// A horizontal stretch of one colour: columns u_first..u_last of row v.
struct Run {
  int v;
  int u_first;
  int u_last;
};

struct Region {
  Colour colour{};
  int area_px = 0;
  int u_min = 0, u_max = 0, v_min = 0, v_max = 0;
  float u_mean = 0, v_mean = 0;
  bool at_border = false;  // It touches the image's edge, so a part may lie outside.
  std::vector<Run> runs;   // By row, then column.

  float width_px() const { return static_cast<float>(u_max - u_min + 1); }
  float height_px() const { return static_cast<float>(v_max - v_min + 1); }
};

// The regions (8-connected) of at least this size, largest first; ties by position.
std::vector<Region> find_regions(const ColourMask& mask, Colour colour, int min_area_px);

}  // namespace seam::sdk
