// How finely light is sampled.
#pragma once

#include <memory>

#include "sim_core/base/time.h"

namespace seam::render {

class GlDevice;
class RayStore;

struct RendererOptions {
  // At least so many samples fall on a pixel, spread over its square and its row's instants.
  int samples_per_pixel = 8;
  // Where colours meet, a pixel gets at least so many.
  int edge_samples_per_pixel = 64;
  // Where a point would move further than this between two instants, the scene is interpolated
  // at more instants in between.
  double max_motion_px = 1;
  // One frame may be split over so many threads (the same bits for any number).
  int threads = 1;
  // Time of the set's (or run's) start: what flicker, drift and time-dependent expressions count
  // from.
  SimTime reference;
  // Draws in place of the ray caster where given; outlives the renderers that use it.
  const GlDevice* opengl = nullptr;
  // Renderers that are given the same one find the rays of equal cameras once.
  std::shared_ptr<RayStore> ray_store;
};

}  // namespace seam::render
