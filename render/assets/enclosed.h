// Whether a place is inside a solid: a camera there sees nothing but the solid's inner side.
#pragma once

#include "render/assets/assets.h"
#include "sim_core/scene/scene.h"

namespace seam::render {

// `p_O`: in the primitive's frame. Meshes need not be closed: a place is inside where their
// triangles cover more than half of all directions.
bool is_inside(const Primitive& primitive, const Vec3& p_O, const Assets& assets);

}  // namespace seam::render
