// A scene at one instant, made ready for the ray caster: primitives in the camera's frame, with
// conservative bounds of where the image can show them.
#pragma once

#include <vector>

#include "render/cast/cast_kernels.h"
#include "render/cast/ray_table.h"
#include "sim_core/scene/scene.h"

namespace seam::render {

// An edge of a primitive's straight outline on the plane z = 1, from the smaller to the greater y,
// and its x for each y.
struct OutlineEdge {
  float x0, y0, x1, y1, slope;
};

// The way of an upright rectangle on the plane z = 1 that moves evenly and holds, at its start and
// end, the images of a capsule's two balls: all of the capsule is seen along it.
struct Sweep {
  float x_min[2], x_max[2], y_min[2], y_max[2];
};

// Where a primitive can be seen: rows [first_row, last_row] of the camera's rays, and in these its
// x (on the plane z = 1) within [x_min, x_max], or tighter inside its outline or along its sweep,
// if it has one.
struct Footprint {
  int first_row = 0;
  int last_row = -1;
  float x_min = 0;
  float x_max = 0;
  int first_edge = 0;
  int edges = 0;
  int sweep = -1;
};

struct PreparedInstant {
  std::vector<CastShape>
      shapes;  // Visible ones, in the scene's order; CastShape::id is the place here.
  std::vector<uint8_t> kinds;  // Shape of each, as the kernels count them.
  std::vector<Footprint> footprints;
  // Place 0 is the background; a hit's id + 1 is its place.
  std::vector<Colour> colours;
  // Equal for hits that look the same: of one colour, or with Lambert's law of one primitive.
  std::vector<uint32_t> signatures;
  std::vector<int> sources;  // Places in SceneInstant::primitives.
  std::vector<OutlineEdge> outline_edges;
  std::vector<Sweep> sweeps;

  void clear();
  void reserve(size_t primitives);
};

// Rows of a camera's rays, both included.
struct RowRange {
  int first = 0;
  int last = -1;
};

// Whether these rows can see anything of a ball about this point, in the camera's frame.
bool may_be_seen(const Vec3& centre_C, double radius, const CameraRays& rays, RowRange rows);

// What these rows can see.
void prepare(const SceneInstant& instant, const Lighting& lighting, const Rgb& background,
             const CameraRays& rays, RowRange rows, PreparedInstant& out);

// A ball about a primitive, in its own frame.
Vec3 bounding_centre(const Primitive& primitive);
double bounding_radius(const Primitive& primitive);

}  // namespace seam::render
