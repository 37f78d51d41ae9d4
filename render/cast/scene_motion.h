// How a scene moves between two instants.
#pragma once

#include "sim_core/scene/scene.h"

namespace seam::render {

// The scene at `time` between (or a little beyond) two instants: poses are interpolated, which is
// exact for constant velocities and good to the third power of the angle turned in between.
SceneInstant interpolate(const SceneInstant& a, const SceneInstant& b, SimTime time);

// An upper bound of how far any visible point moves in the image from a to b, pixels; focal_px is
// the greatest number of pixels per unit of x or y.
double image_motion_px(const SceneInstant& a, const SceneInstant& b, double focal_px);
// A bound of that bound, at less work.
double image_motion_bound_px(const SceneInstant& a, const SceneInstant& b, double focal_px);

}  // namespace seam::render
