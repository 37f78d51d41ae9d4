// Images before the sensor.
#pragma once

#include <array>
#include <vector>

namespace seam::render {

// Linear light, one plane for each of red, green and blue, row-major.
struct LinearImage {
  int width_px = 0;
  int height_px = 0;
  std::array<std::vector<float>, 3> planes;
};

}  // namespace seam::render
