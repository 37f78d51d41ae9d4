#include "render/cast/prepared_scene.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace seam::render {
namespace {

// Bounds on the plane z = 1.
struct Bounds {
  double x_min = 1e30, x_max = -1e30, y_min = 1e30, y_max = -1e30;
  void add(double x, double y) {
    x_min = std::min(x_min, x), x_max = std::max(x_max, x);
    y_min = std::min(y_min, y), y_max = std::max(y_max, y);
  }
  void add(const Bounds& other) { add(other.x_min, other.y_min), add(other.x_max, other.y_max); }
  static Bounds everything() { return {-1e30, 1e30, -1e30, 1e30}; }
};

// A radius of at least the bounding sphere's, without a root.
double loose_radius(const Primitive& primitive) {
  const Vec3& size = primitive.size;
  switch (primitive.shape) {
    case Shape::rectangle:
      return 0.5 * (size.x + size.y);
    case Shape::sphere:
    case Shape::mesh:
      return size.x;
    case Shape::cylinder:
    case Shape::capsule:
      return size.x + 0.5 * size.z;
    case Shape::box:
      return 0.5 * (size.x + size.y + size.z);
  }
  return 0;
}

// Nothing of the sphere lies inside the pyramid of these rows' rays.
bool outside_view(const Vec3& centre_C, double radius, const CameraRays& rays, RowRange rows) {
  if (!rays.perspective) return false;
  if (centre_C.z < -radius) return true;
  const auto beyond = [&](double along, double limit) {
    // Distance from the plane along = limit * z, whose normal has the length sqrt(1 + limit^2).
    const double distance = along - limit * centre_C.z;
    return distance > 0 && distance * distance > radius * radius * (1 + limit * limit);
  };
  return beyond(centre_C.x, rays.x_max) || beyond(-centre_C.x, -rays.x_min) ||
         beyond(centre_C.y, rays.row_y_max[rows.last]) ||
         beyond(-centre_C.y, -rays.row_y_min[rows.first]);
}

// The tangent planes through the camera that hold a sphere between them, on one axis.
bool sphere_interval(double along, double z, double radius, double& low, double& high) {
  const double below = z * z - radius * radius;
  if (z <= radius || below <= 0) return false;
  const double half = radius * std::sqrt(along * along + below);
  low = (along * z - half) / below;
  high = (along * z + half) / below;
  return true;
}

Bounds sphere_bounds(const Vec3& centre_C, double radius) {
  Bounds bounds;
  if (!sphere_interval(centre_C.x, centre_C.z, radius, bounds.x_min, bounds.x_max) ||
      !sphere_interval(centre_C.y, centre_C.z, radius, bounds.y_min, bounds.y_max)) {
    return Bounds::everything();
  }
  return bounds;
}

// Of what lies between corners in the object's frame.
Bounds corner_bounds(const Pose& X_CO, const Vec3& low, const Vec3& high) {
  Bounds bounds;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p_C = X_CO * Vec3(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                                 corner & 4 ? high.z : low.z);
    if (p_C.z < kNear) return Bounds::everything();
    bounds.add(p_C.x / p_C.z, p_C.y / p_C.z);
  }
  return bounds;
}

// Where the way from one point to the other crosses the near plane.
Vec3 at_near_plane(const Vec3& from, const Vec3& to) {
  Vec3 cut = from + (kNear - from.z) / (to.z - from.z) * (to - from);
  cut.z = kNear;
  return cut;
}

void add_edge(const Vec3& p, const Vec3& q, Bounds& bounds, std::pmr::vector<OutlineEdge>& edges) {
  const double px = p.x / p.z, py = p.y / p.z, qx = q.x / q.z, qy = q.y / q.z;
  bounds.add(px, py), bounds.add(qx, qy);
  OutlineEdge edge{static_cast<float>(px), static_cast<float>(py), static_cast<float>(qx),
                   static_cast<float>(qy), 0.0f};
  if (edge.y0 > edge.y1) std::swap(edge.x0, edge.x1), std::swap(edge.y0, edge.y1);
  const float dy = edge.y1 - edge.y0;
  if (dy > 1e-12f)
    edge.slope = (edge.x1 - edge.x0) / dy;
  else
    edge.y1 = edge.y0;
  edges.push_back(edge);
}

// The rectangle's outline, cut off at the near plane.
Bounds rectangle_bounds(const Pose& X_CO, const Vec3& size, std::pmr::vector<OutlineEdge>& edges) {
  const Vec3 a = 0.5 * size.x * X_CO.R[0], b = 0.5 * size.y * X_CO.R[1];
  const Vec3 corners[4] = {X_CO.p - a - b, X_CO.p + a - b, X_CO.p + a + b, X_CO.p - a + b};
  Vec3 outline[8];
  int count = 0;
  for (int k = 0; k < 4; ++k) {
    const Vec3& from = corners[k];
    const Vec3& to = corners[(k + 1) % 4];
    if (from.z >= kNear) outline[count++] = from;
    if ((from.z >= kNear) != (to.z >= kNear)) outline[count++] = at_near_plane(from, to);
  }
  Bounds bounds;
  for (int k = 0; k < count; ++k) add_edge(outline[k], outline[(k + 1) % count], bounds, edges);
  return bounds;
}

// The box's outline, cut off at the near plane: edges between a face that looks at the camera and
// one that does not, and where the near plane cuts faces that do.
Bounds box_bounds(const Pose& X_CO, const Vec3& half, std::pmr::vector<OutlineEdge>& edges) {
  bool faces_camera[3][2];
  bool inside = true;
  for (int axis = 0; axis < 3; ++axis) {
    const double camera = -glm::dot(X_CO.R[axis], X_CO.p);
    faces_camera[axis][0] = camera<-half[axis], faces_camera[axis][1] = camera> half[axis];
    inside &= !faces_camera[axis][0] && !faces_camera[axis][1];
  }
  if (inside) return Bounds::everything();
  Vec3 corners[8];
  for (int corner = 0; corner < 8; ++corner) {
    corners[corner] = X_CO.p + (corner & 1 ? half.x : -half.x) * X_CO.R[0] +
                      (corner & 2 ? half.y : -half.y) * X_CO.R[1] +
                      (corner & 4 ? half.z : -half.z) * X_CO.R[2];
  }
  Bounds bounds;
  Vec3 cuts[3][2][2];
  int cuts_of[3][2] = {};
  for (int along = 0; along < 3; ++along) {
    const int b = (along + 1) % 3, c = (along + 2) % 3;
    for (int side = 0; side < 4; ++side) {
      const int side_b = side & 1, side_c = side >> 1;
      const bool front_b = faces_camera[b][side_b], front_c = faces_camera[c][side_c];
      if (!front_b && !front_c) continue;
      const int low = (side_b << b) | (side_c << c);
      Vec3 from = corners[low], to = corners[low | (1 << along)];
      if (from.z < kNear && to.z < kNear) continue;
      if (from.z < kNear || to.z < kNear) {
        const Vec3 cut = at_near_plane(from, to);
        (from.z < kNear ? from : to) = cut;
        if (front_b) cuts[b][side_b][cuts_of[b][side_b]++] = cut;
        if (front_c) cuts[c][side_c][cuts_of[c][side_c]++] = cut;
      }
      if (front_b != front_c) add_edge(from, to, bounds, edges);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const Vec3(&cut)[2] = cuts[axis][side];
      if (cuts_of[axis][side] == 2) add_edge(cut[0], cut[1], bounds, edges);
    }
  }
  return bounds;
}

// Of a capsule, its sweep too where both its balls are in front of the camera.
Bounds capsule_bounds(const Vec3& foot_C, const Vec3& top_C, double radius,
                      std::pmr::vector<Sweep>& sweeps) {
  const Bounds foot = sphere_bounds(foot_C, radius), top = sphere_bounds(top_C, radius);
  Bounds both = foot;
  both.add(top);
  if (both.x_max < 1e30) {
    const auto pair = [](float(&to)[2], double first, double last) {
      to[0] = static_cast<float>(first), to[1] = static_cast<float>(last);
    };
    Sweep& sweep = sweeps.emplace_back();
    pair(sweep.x_min, foot.x_min, top.x_min), pair(sweep.x_max, foot.x_max, top.x_max);
    pair(sweep.y_min, foot.y_min, top.y_min), pair(sweep.y_max, foot.y_max, top.y_max);
  }
  return both;
}

Bounds bounds_of(const Primitive& primitive, const Pose& X_CO, PreparedInstant& out) {
  const Vec3& size = primitive.size;
  std::pmr::vector<OutlineEdge>& edges = out.outline_edges;
  switch (primitive.shape) {
    case Shape::rectangle:
      return rectangle_bounds(X_CO, size, edges);
    case Shape::sphere:
      return sphere_bounds(X_CO.p, size.x);
    case Shape::cylinder:
      return corner_bounds(X_CO, {-size.x, -size.x, 0}, {size.x, size.x, size.z});
    case Shape::capsule:
      return capsule_bounds(X_CO.p, X_CO.p + size.z * X_CO.R[2], size.x, out.sweeps);
    case Shape::box:
      return box_bounds(X_CO, 0.5 * size, edges);
    case Shape::mesh:
      return sphere_bounds(X_CO.p, size.x);
  }
  return Bounds::everything();
}

Footprint footprint_of(const Bounds& bounds, const CameraRays& rays, RowRange rows) {
  constexpr float kSlack = 1e-5f;
  Footprint footprint;
  if (!rays.perspective) {
    footprint.first_row = rows.first, footprint.last_row = rows.last;
    footprint.x_min = -1e30f, footprint.x_max = 1e30f;
    return footprint;
  }
  const auto& y_max = rays.row_y_max;
  const auto& y_min = rays.row_y_min;
  footprint.first_row = static_cast<int>(
      std::lower_bound(y_max.begin(), y_max.end(), static_cast<float>(bounds.y_min) - kSlack) -
      y_max.begin());
  footprint.last_row =
      static_cast<int>(
          std::upper_bound(y_min.begin(), y_min.end(), static_cast<float>(bounds.y_max) + kSlack) -
          y_min.begin()) -
      1;
  footprint.x_min = static_cast<float>(bounds.x_min) - kSlack;
  footprint.x_max = static_cast<float>(bounds.x_max) + kSlack;
  footprint.first_row = std::max(footprint.first_row, rows.first);
  footprint.last_row = std::min(footprint.last_row, rows.last);
  if (footprint.x_max < rays.x_min || footprint.x_min > rays.x_max) footprint.last_row = -1;
  return footprint;
}

CastShape cast_shape(const Primitive& primitive, const Pose& X_CO, const Vec3& light_C,
                     const Lighting& lighting) {
  CastShape shape{};
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 3; ++k) shape.R_OC[3 * axis + k] = static_cast<float>(X_CO.R[axis][k]);
    shape.origin_O[axis] = static_cast<float>(-glm::dot(X_CO.R[axis], X_CO.p));
    shape.centre_C[axis] = static_cast<float>(X_CO.p[axis]);
    shape.light_O[axis] = static_cast<float>(lighting.diffuse * glm::dot(X_CO.R[axis], light_C));
    const bool half_edges = primitive.shape == Shape::rectangle || primitive.shape == Shape::box;
    shape.size[axis] =
        static_cast<float>(half_edges ? 0.5 * primitive.size[axis] : primitive.size[axis]);
  }
  shape.ambient = static_cast<float>(lighting.ambient);
  return shape;
}

Colour colour_of(const Rgb& rgb) {
  return {
      {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2]), 0.0f}};
}

uint32_t signature_of(const Primitive& primitive, size_t source, const Lighting& lighting) {
  if (lighting.lambert) return static_cast<uint32_t>(source) + 1;
  uint32_t mixed = 0x9e3779b9u;
  for (const double channel : primitive.rgb) {
    mixed = (mixed ^ std::bit_cast<uint32_t>(static_cast<float>(channel))) * 0x85ebca6bu;
    mixed ^= mixed >> 13;
  }
  return mixed | 1u;
}

}  // namespace

bool may_be_seen(const Vec3& centre_C, double radius, const CameraRays& rays, RowRange rows) {
  return !outside_view(centre_C, radius, rays, rows);
}

void PreparedInstant::clear() {
  shapes.clear(), kinds.clear(), footprints.clear(), colours.clear(), signatures.clear();
  sources.clear(), outline_edges.clear(), sweeps.clear();
}

void PreparedInstant::reserve(size_t primitives) {
  shapes.reserve(primitives), kinds.reserve(primitives), footprints.reserve(primitives);
  colours.reserve(primitives + 1), signatures.reserve(primitives + 1), sources.reserve(primitives);
  outline_edges.reserve(4 * primitives), sweeps.reserve(primitives);
}

void prepare(const Pose& X_WC, std::span<const Shown> shown, const FrameJob& job,
             const CameraRays& rays, RowRange rows, PreparedInstant& out) {
  const Lighting& lighting = job.lighting;
  out.clear();
  // About as many as a few rows see, for which PreparedInstant::memory is enough.
  out.reserve(32);
  out.colours.push_back(colour_of(job.background));
  out.signatures.push_back(0);
  const Pose X_CW = X_WC.inverse();
  const Vec3 light_C = X_CW.R * lighting.direction_W;
  for (const auto& [source, place] : shown) {
    const Primitive& primitive = *source;
    if (primitive.shape == Shape::mesh) continue;  // Triangles are OpenGL's alone.
    const Vec3 centre_C = X_CW * (primitive.X_WO * bounding_centre(primitive));
    if (outside_view(centre_C, loose_radius(primitive), rays, rows) ||
        outside_view(centre_C, bounding_radius(primitive), rays, rows)) {
      continue;
    }
    const Pose X_CO = X_CW * primitive.X_WO;
    const size_t first_edge = out.outline_edges.size(), sweep = out.sweeps.size();
    Footprint footprint = footprint_of(bounds_of(primitive, X_CO, out), rays, rows);
    if (footprint.last_row < footprint.first_row) {
      out.outline_edges.resize(first_edge), out.sweeps.resize(sweep);
      continue;
    }
    if (rays.perspective) {
      footprint.first_edge = static_cast<int>(first_edge);
      footprint.edges = static_cast<int>(out.outline_edges.size() - first_edge);
      if (out.sweeps.size() > sweep) footprint.sweep = static_cast<int>(sweep);
    }
    CastShape shape = cast_shape(primitive, X_CO, light_C, lighting);
    shape.id = static_cast<int32_t>(out.shapes.size());
    out.shapes.push_back(shape);
    out.kinds.push_back(static_cast<uint8_t>(primitive.shape));
    out.footprints.push_back(footprint);
    out.colours.push_back(colour_of(primitive.rgb));
    out.signatures.push_back(signature_of(primitive, static_cast<size_t>(place), lighting));
    out.sources.push_back(place);
  }
}

void prepare(const SceneInstant& instant, const FrameJob& job, const CameraRays& rays,
             RowRange rows, PreparedInstant& out) {
  std::vector<Shown> all;
  all.reserve(instant.primitives.size());
  for (size_t i = 0; i < instant.primitives.size(); ++i)
    all.push_back({&instant.primitives[i], static_cast<int>(i)});
  prepare(instant.X_WC, all, job, rays, rows, out);
}

}  // namespace seam::render
