// What a thing covers of the ground, for views from above.
#pragma once

#include <array>
#include <vector>

#include "render/assets/assets.h"
#include "sim_core/scene/scene.h"

namespace seam::tools {

struct Footprint {
  // Metres in W, counter-clockwise: the hull of its points as they are seen from above. Two corners
  // where it stands upright and has no thickness.
  std::vector<std::array<double, 2>> corners;
  double top_m = 0;
};

// Circles have 24 corners. `assets`: where the triangles of meshes are; a mesh without is the
// sphere that it is known to be in.
Footprint footprint_of(const Primitive& primitive, const render::Assets* assets);

}  // namespace seam::tools
