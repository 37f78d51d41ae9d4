// A scene at one instant, made ready for the ray caster: primitives in the camera's frame, with
// conservative bounds of where the image can show them.
#pragma once

#include <memory_resource>
#include <span>
#include <vector>

#include "render/cast/cast_kernels.h"
#include "render/cast/ray_table.h"
#include "sim_core/scene/bounding_ball.h"
#include "sim_core/scene/frame.h"

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
  // Of all that follows, taken in one piece: a frame has many instants.
  std::pmr::monotonic_buffer_resource memory{9 << 10};
  // Visible ones, in the scene's order; CastShape::id is the place here.
  std::pmr::vector<CastShape> shapes{&memory};
  std::pmr::vector<uint8_t> kinds{&memory};  // Shape of each, as the kernels count them.
  std::pmr::vector<Footprint> footprints{&memory};
  // Place 0 is the background; a hit's id + 1 is its place.
  std::pmr::vector<Colour> colours{&memory};
  // Equal for hits that look the same: of one colour, or with Lambert's law of one primitive.
  std::pmr::vector<uint32_t> signatures{&memory};
  std::pmr::vector<int> sources{&memory};  // Places among the instant's primitives.
  std::pmr::vector<OutlineEdge> outline_edges{&memory};
  std::pmr::vector<Sweep> sweeps{&memory};

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

// What these rows can see of some of an instant's primitives, which come in their order.
struct Shown {
  const Primitive* primitive;
  int place;  // Among all of the instant.
};
void prepare(const Pose& X_WC, std::span<const Shown> shown, const FrameJob& job,
             const CameraRays& rays, RowRange rows, PreparedInstant& out);
// The same of all, for an instant that has nothing but primitives.
void prepare(const SceneInstant& instant, const FrameJob& job, const CameraRays& rays,
             RowRange rows, PreparedInstant& out);

}  // namespace seam::render
