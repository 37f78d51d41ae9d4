// How much the corners that a detector found scatter, estimated from the pictures.
#pragma once

#include <vector>

#include "app/import/draft/points_draft.h"

namespace seam::app {

struct Scatter {
  double all_px = 0;            // One sigma of one coordinate, over all views; 0: unknown.
  std::vector<double> view_px;  // Of each view, drawn to that of all where it has few points.
};

// What a smooth map from the target to the picture leaves, a perspective and a cubic: no lens has
// to be known. What the target itself is off its plan counts as scatter.
Scatter scatter_of(const std::vector<SeenView>& views);

}  // namespace seam::app
