// A ball about a primitive, in its own frame.
#pragma once

#include "sim_core/scene/scene.h"

namespace seam {

Vec3 bounding_centre(const Primitive& primitive);
double bounding_radius(const Primitive& primitive);

}  // namespace seam
