// The inner loops of looking up a row's samples on a page of the film strip; compiled for each
// vector width as cast/cast_kernels.h, with the same bits for all.
#pragma once

#include <cstdint>

#include "render/cast/cast_kernels.h"

namespace seam::render::gl {

// How a ray's place on the plane z = 1 becomes a texel of the page.
struct TexelGrid {
  float u_per_x, u_per_y, v_per_y;
  float offset_u, offset_v;  // So that places on the page are positive.
  int width, height;         // Of the band; samples beyond it take the nearest texel.
};

struct GatherKernels {
  // Texels of one sample of each of a row's pixels, at (du, dv) from their centres.
  void (*find)(const RaySlopes& x, const RaySlopes& y, float du, float dv, const TexelGrid& grid,
               int count, int32_t* texels);
  // Texels that are places in a palette: adds its colours to the pixels' sums, or one part of them.
  void (*add_indexed)(const float* page, const int32_t* texels, const Colour* palette, int count,
                      float* sums);
  void (*add_indexed_one)(const float* page, const int32_t* texels, const float* palette, int count,
                          float* sums);
  // Adds the texels, four floats each, to the pixels' sums.
  void (*add)(const float* page, const int32_t* texels, int count, float* sums);
  // The same of one of the four floats; the sums are of that one alone.
  void (*add_one)(const float* page, const int32_t* texels, int count, float* sums);
};

const GatherKernels& gather_kernels();

}  // namespace seam::render::gl
