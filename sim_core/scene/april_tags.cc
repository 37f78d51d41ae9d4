#include "sim_core/scene/april_tags.h"

// The library's pictures are declared without saying that they are C's.
extern "C" {
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
}

#include <memory>

#include "sim_core/base/error.h"

namespace seam {

std::vector<LightCells> light_cells_of_tag(int id) {
  SEAM_CHECK(id >= 0 && id < kMostTags, "tag {}", id);
  const std::unique_ptr<apriltag_family_t, decltype(&tag36h11_destroy)> family(tag36h11_create(),
                                                                               tag36h11_destroy);
  // With a ring of white around the tag.
  const std::unique_ptr<image_u8_t, decltype(&image_u8_destroy)> picture(
      apriltag_to_image(family.get(), id), image_u8_destroy);
  const auto is_light = [&](int row, int column) {
    return picture->buf[(row + 1) * picture->stride + column + 1] != 0;
  };
  std::vector<LightCells> cells;
  for (int row = 0; row < kTagCells; ++row) {
    for (int column = 0; column < kTagCells; ++column) {
      if (!is_light(row, column)) continue;
      if (column > 0 && is_light(row, column - 1))
        ++cells.back().count;
      else
        cells.push_back({row, column, 1});
    }
  }
  return cells;
}

}  // namespace seam
