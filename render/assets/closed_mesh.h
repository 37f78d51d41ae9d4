// Whether a mesh is closed, so that from outside none of its far sides is ever seen.
#pragma once

#include "render/assets/assets.h"

namespace seam::render {

// 1 where the triangles enclose bodies and all run counter-clockwise as seen from outside, -1 where
// all run clockwise; 0 where there is an edge, or some run one way and some the other.
int turn_seen_from_outside(const Mesh& mesh);

}  // namespace seam::render
