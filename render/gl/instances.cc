#include "render/gl/instances.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace seam::render::gl {
namespace {

constexpr int kMostLayers = 500;
constexpr double kLayerNearness = 2e-5;

using PlaneKey = std::array<int64_t, 4>;

// Planes that differ by no more than rounding have one key.
PlaneKey key_of(Vec3 normal, const Vec3& point) {
  // One of the two directions.
  const double side = normal.z + 0.0123 * normal.y + 0.000345 * normal.x;
  if (side < 0) normal = -normal;
  const auto rounded = [](double value, double step) {
    return static_cast<int64_t>(std::floor(value / step + 0.12347));
  };
  return {rounded(normal.x, 1e-5), rounded(normal.y, 1e-5), rounded(normal.z, 1e-5),
          rounded(glm::dot(normal, point), 1e-5)};
}

std::vector<PlaneKey> planes_of(const Primitive& primitive) {
  const Pose& X = primitive.X_WO;
  if (primitive.shape == Shape::rectangle) return {key_of(X.R[2], X.p)};
  std::vector<PlaneKey> planes;
  if (primitive.shape != Shape::box) return planes;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-0.5, 0.5})
      planes.push_back(key_of(X.R[axis], X.p + side * primitive.size[axis] * X.R[axis]));
  }
  return planes;
}

// From a texel's middle on the page to its place on the grid, and what a texel is on the plane z
// = 1.
std::array<float, 4> ray_of(const BandPlace& where) {
  return {static_cast<float>(where.band.first_x) - where.band.shift_u,
          static_cast<float>(where.band.first_y - where.band.page_y) - where.band.shift_v,
          1.0f / where.scale.u_per_unit, 1.0f / where.scale.v_per_unit};
}

// Clusters that follow each other are one run. With a turn, those that look away are left out.
std::vector<MeshInstance::Run> runs_seen(const ClusteredMesh& mesh, const Pose& X_CO, int turn,
                                         const CameraRays& rays, RowRange rows) {
  const Vec3 camera_O = X_CO.inverse().p;
  std::vector<MeshInstance::Run> runs;
  for (uint32_t part = 0; part < mesh.parts.size(); ++part) {
    for (const MeshCluster& cluster : mesh.parts[part].clusters) {
      if (turn != 0 && cluster.looks_away(camera_O, turn)) continue;
      if (!may_be_seen(X_CO * cluster.centre, cluster.radius, rays, rows)) continue;
      if (!runs.empty() && runs.back().part == part &&
          runs.back().first + runs.back().count == cluster.first)
        runs.back().count += cluster.count;
      else
        runs.push_back({part, cluster.first, cluster.count, 0});
    }
  }
  return runs;
}

Colour product(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  return {{a[0] * b[0], a[1] * b[1], a[2] * b[2], 0}};
}

// The component of a direction in the camera's frame along an axis of the view's.
float along_view(const StripView& view, const float* d, int axis) {
  const Vec3& along = view.R_CV[axis];
  return static_cast<float>(along.x * d[0] + along.y * d[1] + along.z * d[2]);
}

// One face of a rectangle or a box: the one at `side` (-1, 0, 1) times the half edge `axis`.
void add_face(const CastShape& shape, int axis, float side, const BandPlace& where,
              FaceInstance face, bool lambert, PageScene& out) {
  const auto in_view = [&](const float* d, int k) { return along_view(where.view, d, k); };
  // The normal looks at the camera.
  const float towards = shape.origin_O[axis] >= 0 ? 1.0f : -1.0f;
  const float away = side * shape.size[axis] - shape.origin_O[axis];
  if (std::abs(away) < 1e-9f) return;
  const float* const normal = &shape.R_OC[3 * axis];
  const float* const a = &shape.R_OC[3 * ((axis + 1) % 3)];
  const float* const b = &shape.R_OC[3 * ((axis + 2) % 3)];
  for (int k = 0; k < 3; ++k) {
    face.centre[k] = in_view(shape.centre_C, k) + side * shape.size[axis] * in_view(normal, k);
    face.along_a[k] = shape.size[(axis + 1) % 3] * in_view(a, k);
    face.along_b[k] = shape.size[(axis + 2) % 3] * in_view(b, k);
    face.plane[k] = in_view(normal, k) / away;
  }
  // Cut off just before the nearest of it that the band can show: a side that runs past the camera
  // would have ends so far out that a float places it badly.
  float nearest = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const float u = corner & 1 ? static_cast<float>(where.page.width) : 0.0f;
    const float v = corner & 2 ? face.along_a[3] : face.centre[3];
    const float row = v + face.ray[1];
    nearest = std::max(nearest,
                       face.plane[0] * (u + face.ray[0] - where.scale.shear * row) * face.ray[2] +
                           face.plane[1] * row * face.ray[3] + face.plane[2]);
  }
  if (nearest <= 0) return;
  face.along_b[3] = std::max(0.9f / nearest, kNear);
  const float factor =
      lambert ? shape.ambient + std::max(towards * shape.light_O[axis], 0.0f) : 1.0f;
  for (int k = 0; k < 3; ++k) face.look[k] *= factor;
  out.faces.push_back(face);
}

void add_faces(const CastShape& shape, Shape kind, const BandPlace& where, const FaceInstance& face,
               bool lambert, PageScene& out) {
  if (kind == Shape::rectangle) return add_face(shape, 2, 0, where, face, lambert, out);
  // Of a box those that the camera is in front of.
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(shape.origin_O[axis]) > shape.size[axis]) {
      const float side = shape.origin_O[axis] > 0 ? 1.0f : -1.0f;
      add_face(shape, axis, side, where, face, lambert, out);
    }
  }
}

}  // namespace

PaintLayers::PaintLayers(const SceneInstant& scene) {
  std::map<PlaneKey, int> top;
  for (const Primitive& primitive : scene.primitives) {
    int layer = 0;
    const std::vector<PlaneKey> planes = planes_of(primitive);
    for (const PlaneKey& plane : planes) {
      const auto found = top.find(plane);
      if (found != top.end()) layer = std::max(layer, found->second + 1);
    }
    layer = std::min(layer, kMostLayers);
    for (const PlaneKey& plane : planes) top[plane] = layer;
    layers_.push_back({primitive.object_id, primitive.shape, layer});
  }
}

float PaintLayers::nearness(const SceneInstant& scene, size_t place) const {
  if (place >= layers_.size()) return 1;
  // Robots may be left out of an instant, and what follows them has another place.
  const Layer& layer = layers_[place];
  const Primitive& primitive = scene.primitives[place];
  if (layer.object_id != primitive.object_id || layer.shape != primitive.shape) return 1;
  return static_cast<float>(1 + kLayerNearness * layer.layer);
}

float Palette::index_of(const Colour& colour) {
  const auto [found, added] = places_.try_emplace({colour.rgb[0], colour.rgb[1], colour.rgb[2]},
                                                  static_cast<int>(colours_.size()));
  if (added) colours_.push_back(colour);
  return static_cast<float>(found->second);
}

void add_shapes(const PreparedInstant& prepared, const SceneInstant& scene,
                const PaintLayers& layers, const BandPlace& where, const CameraRays& rays,
                bool lambert, Palette* palette, PageScene& out) {
  const Band& band = where.band;
  const StripScale& scale = where.scale;
  const StripView& view = where.view;
  const auto low_y = static_cast<float>(band.page_y);
  const auto high_y = static_cast<float>(band.page_y + band.height);
  const std::array<float, 4> ray = ray_of(where);
  for (size_t i = 0; i < prepared.shapes.size(); ++i) {
    const CastShape& shape = prepared.shapes[i];
    const Footprint& footprint = prepared.footprints[i];
    const auto source = static_cast<size_t>(prepared.sources[i]);
    const auto kind = static_cast<Shape>(prepared.kinds[i]);
    const float identity =
        palette ? palette->index_of(prepared.colours[i + 1]) : static_cast<float>(source + 1);
    const uint32_t texture = scene.primitives[source].asset;
    if (texture == 0 && (kind == Shape::rectangle || kind == Shape::box)) {
      FaceInstance face{};
      face.centre[3] = low_y, face.along_a[3] = high_y;
      face.plane[3] = layers.nearness(scene, source);
      for (int k = 0; k < 3; ++k) face.look[k] = prepared.colours[i + 1].rgb[k];
      face.look[3] = identity;
      std::copy(ray.begin(), ray.end(), face.ray);
      add_faces(shape, kind, where, face, lambert, out);
      continue;
    }
    ShapeInstance instance{};
    float* const place = instance.place;
    place[0] = view.x_min, place[2] = view.x_max, place[1] = low_y, place[3] = high_y;
    if (rays.perspective) {
      const auto row = [&](float y) { return y * scale.v_per_unit - ray[1]; };
      place[0] = std::max(place[0], footprint.x_min),
      place[2] = std::min(place[2], footprint.x_max);
      place[1] = std::max(row(view.row_y_min[footprint.first_row]) - 2, low_y);
      place[3] = std::min(row(view.row_y_max[footprint.last_row]) + 2, high_y);
    }
    place[0] = place[0] * scale.u_per_unit - 2, place[2] = place[2] * scale.u_per_unit + 2;
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = 0; k < 3; ++k)
        instance.R_OV_and_origin[axis][k] = along_view(view, &shape.R_OC[3 * axis], k);
      instance.R_OV_and_origin[axis][3] = shape.origin_O[axis];
      instance.size_and_ambient[axis] = shape.size[axis];
      instance.light_and_depth[axis] = lambert ? shape.light_O[axis] : 0.0f;
      instance.look[axis] = prepared.colours[i + 1].rgb[axis];
    }
    instance.size_and_ambient[3] = lambert ? shape.ambient : 1.0f;
    instance.light_and_depth[3] = layers.nearness(scene, source);
    instance.look[3] = identity;
    std::copy(ray.begin(), ray.end(), instance.ray);
    out.shapes[{prepared.kinds[i], texture}].push_back(instance);
  }
}

void add_meshes(const SceneInstant& scene, const std::vector<ClusteredMesh>& meshes,
                const BandPlace& where, const CameraRays& rays, const Lighting& lighting,
                Palette* palette, PageScene& out) {
  const auto& [band, page, scale, view] = where;
  const Pose X_CW = scene.X_WC.inverse();
  for (size_t source = 0; source < scene.primitives.size(); ++source) {
    const Primitive& primitive = scene.primitives[source];
    if (primitive.shape != Shape::mesh || primitive.asset == 0) continue;
    const Pose X_CO = X_CW * primitive.X_WO;
    if (!may_be_seen(X_CO.p, primitive.size.x, rays, band.rows)) continue;
    const ClusteredMesh& mesh = meshes.at(primitive.asset - 1);
    // Cut open by the lens in front of it, a closed mesh shows its far sides.
    const bool outside =
        glm::dot(X_CO.p, X_CO.p) > (primitive.size.x + 0.01) * (primitive.size.x + 0.01);
    const int turn = outside ? mesh.turn : 0;
    std::vector<MeshInstance::Run> runs = runs_seen(mesh, X_CO, turn, rays, band.rows);
    if (runs.empty()) continue;
    const Mat3 R_VC = glm::transpose(view.R_CV);
    const Mat3 R_VO = R_VC * X_CO.R;
    const Vec3 p_VO = R_VC * X_CO.p;
    const Vec3 light = lighting.diffuse * (R_VC * (X_CW.R * lighting.direction_W));
    MeshInstance instance{
        .mesh = primitive.asset - 1, .first_row = band.page_y, .rows = band.height, .turn = turn};
    for (int k = 0; k < 9; ++k) instance.R_VO[k] = static_cast<float>(R_VO[k / 3][k % 3]);
    for (int k = 0; k < 3; ++k) {
      instance.p_VO[k] = static_cast<float>(p_VO[k]);
      instance.light_V[k] = lighting.lambert ? static_cast<float>(light[k]) : 0.0f;
      instance.rgb[k] = static_cast<float>(primitive.rgb[k]);
    }
    instance.light_V[3] = lighting.lambert ? static_cast<float>(lighting.ambient) : 1.0f;
    instance.ray = ray_of(where);
    instance.runs = std::move(runs);
    for (MeshInstance::Run& run : instance.runs) {
      const auto& rgb = mesh.parts[run.part].rgb;
      run.identity = palette && rgb ? palette->index_of(product(*rgb, instance.rgb))
                                    : static_cast<float>(source + 1);
    }
    out.meshes.push_back(std::move(instance));
  }
}

}  // namespace seam::render::gl
