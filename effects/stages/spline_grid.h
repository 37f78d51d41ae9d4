// The control points of the lens of splines: how many there are, and where their values stand among
// the effect's parameters.
#pragma once

namespace seam::effects {

inline constexpr int kSplineRows = 6, kSplineColumns = 8;
inline constexpr int kSplineFov = 0;  // The first parameter's place; the control points' follow.

// Of a part along rows (0) or along columns (1), row by row.
constexpr int spline_place(int row, int column, int part) {
  return kSplineFov + 1 + 2 * (kSplineColumns * row + column) + part;
}

// Shifts, stretches and turns of the whole image, which the principal point, the focal length and
// the poses do, too, would be seven numbers that no fit knows: as many parts of control points are
// stated. Of some choices of seven inside the image the one with the smallest errors.
constexpr bool is_stated_of_splines(int row, int column, int part) {
  const bool at_side = (row == 2 && column == 1) || (row == 3 && column == 6);
  if (part == 0) return at_side || (row == 2 && column == 4);
  return at_side || (row == 1 && column == 3) || (row == 4 && column == 4);
}

}  // namespace seam::effects
