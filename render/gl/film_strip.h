// The film strip: for each instant at which light is sampled, the band of rows that collect light
// then, drawn finer than the image's pixels; the bands of many instants stand on one page, which is
// drawn and read at once. Pixels look up their samples along their own rays, so that the lens's
// true geometry holds for whatever was drawn.
#pragma once

#include <vector>

#include "render/base/linear_image.h"
#include "render/cast/light_integrator.h"

namespace seam::render::gl {

// A flat picture of part of what the camera sees, on the plane z = 1 of its own frame V. A lens of
// narrow view has one, a fisheye one for each side of a cube that it sees.
struct StripView {
  int side = 0;  // Of the cube.
  Mat3 R_CV{1.0};
  float x_min = 0, x_max = 0;
  // By row of rays, as CameraRays has them: the least y from this row on, the greatest up to it.
  std::vector<float> row_y_min, row_y_max;
  bool empty() const { return x_max < x_min; }
};

std::vector<StripView> views_of(const CameraRays& rays);

// The grid of texels. Its rows are staggered, each by another part of a texel, so that the samples
// of a pixel stand in a lattice: each sees an upright edge, and a level one, at another place.
struct StripScale {
  int across = 1, down = 1;  // Texels of a pixel.
  float u_per_unit = 1;      // Texels of x and y on the plane z = 1.
  float v_per_unit = 1;
  float shear = 0;  // Columns by which each row stands further.
};

struct Band {
  int instant = 0;
  RowRange rows;                 // Of rays.
  int first_x = 0, first_y = 0;  // The band's first texel, on the grid of all the view's.
  int height = 0;
  int page_y = 0;
  float shift_u = 0, shift_v = 0;  // Of the grid, texels: each instant has another.
};

struct Page {
  int width = 0, height = 0;
  std::vector<Band> bands;
};

struct StripPlan {
  StripScale scale;
  std::vector<Page> pages;
};

// What a page may hold.
struct PageLimits {
  int side_texels = 8192;     // Of a target; an image that needs more is refused.
  int page_texels = 1 << 18;  // Another page begins where a further band would make it larger.
};

// `samples` has the texels of a pixel. Throws InputError where the image is too large for a target.
StripPlan plan_strip(const SampledInstants& instants, const CameraRays& rays, const StripView& view,
                     StripScale samples, const PageLimits& limits);

// The part of a row of rays' light that it collects at a band's instant; 0: none.
double weight_of(const Band& band, int row, const RowSchedule& schedule, const CameraRays& rays);

// Adds a page's light to the image: four floats a texel, or where there is a palette one, a place
// in it.
void gather_light(const Page& page, const StripScale& scale, const std::vector<float>& texels,
                  const std::vector<Colour>* palette, const StripView& view,
                  const RowSchedule& schedule, const CameraRays& rays, int threads,
                  LinearImage& image);

// What the rays through pixels' centres meet on a page that was drawn for the truth: places in the
// instant's primitives, -1 where nothing is met, and multiples of the ray.
void find_centres(const Page& page, const StripScale& scale, const std::vector<float>& texels,
                  const StripView& view, const RowSchedule& schedule, const CameraRays& rays,
                  std::vector<int32_t>& sources, std::vector<float>& depths);

}  // namespace seam::render::gl
