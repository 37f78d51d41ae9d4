// AprilTags of the family 36h11, as grids of them are printed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace seam {

inline constexpr int kTagCells = 8;    // Along a tag's side, its black border included.
inline constexpr int kMostTags = 587;  // In the family.

// Cells in a row that are light, from `first` on; rows count from the top.
struct LightCells {
  int row = 0;
  int first = 0;
  int count = 0;
};

// What is light of a tag, for ids below kMostTags.
std::vector<LightCells> light_cells_of_tag(int id);

}  // namespace seam
