#include "tools/viewer/footprint.h"

#include <algorithm>

namespace seam::tools {
namespace {

using Corner = std::array<double, 2>;
constexpr int kCircleCorners = 24;

// Points this near are one, and three with so small an area lie on a line.
constexpr double kSame_m = 1e-6, kLine_m2 = 1e-9;

double turn(const Corner& a, const Corner& b, const Corner& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// Andrew's monotone chain (Inf. Process. Lett. 9, 1979).
std::vector<Corner> hull_of(std::vector<Corner> points) {
  std::ranges::sort(points);
  const auto same = [](const Corner& a, const Corner& b) {
    return std::abs(a[0] - b[0]) < kSame_m && std::abs(a[1] - b[1]) < kSame_m;
  };
  points.erase(std::unique(points.begin(), points.end(), same), points.end());
  if (points.size() < 3) return points;
  std::vector<Corner> hull;
  for (int side = 0; side < 2; ++side) {
    const size_t begin = hull.size();
    for (const Corner& point : points) {
      while (hull.size() >= begin + 2 && turn(hull.end()[-2], hull.back(), point) <= kLine_m2)
        hull.pop_back();
      hull.push_back(point);
    }
    hull.pop_back();  // The other side begins with it.
    std::ranges::reverse(points);
  }
  return hull;
}

// A sphere's outline from above is a level circle.
void add_sphere(const Vec3& centre_W, double radius_m, std::vector<Vec3>& points_W) {
  for (int i = 0; i < kCircleCorners; ++i) {
    const double angle_rad = 2 * maths::kPi * i / kCircleCorners;
    points_W.push_back(centre_W + Vec3{radius_m * maths::cos(angle_rad),
                                       radius_m * maths::sin(angle_rad), radius_m});
  }
}

std::vector<Vec3> points_of(const Primitive& primitive, const render::Assets* assets) {
  const Vec3& size = primitive.size;
  std::vector<Vec3> points_W;
  const auto add = [&](const Vec3& p_O) { points_W.push_back(primitive.X_WO * p_O); };
  switch (primitive.shape) {
    case Shape::rectangle:
    case Shape::box:
      for (const double x : {-0.5, 0.5})
        for (const double y : {-0.5, 0.5})
          for (const double z : {-0.5, 0.5})
            add({x * size.x, y * size.y, primitive.shape == Shape::box ? z * size.z : 0.0});
      break;
    case Shape::cylinder:
      for (const double z : {0.0, size.z}) {
        for (int i = 0; i < kCircleCorners; ++i) {
          const double angle_rad = 2 * maths::kPi * i / kCircleCorners;
          add({size.x * maths::cos(angle_rad), size.x * maths::sin(angle_rad), z});
        }
      }
      break;
    case Shape::capsule:
      for (const double z : {0.0, size.z})
        add_sphere(primitive.X_WO * Vec3{0, 0, z}, size.x, points_W);
      break;
    case Shape::sphere:
      add_sphere(primitive.X_WO.p, size.x, points_W);
      break;
    case Shape::mesh:
      if (assets == nullptr || primitive.asset < 1 || primitive.asset > assets->meshes.size()) {
        add_sphere(primitive.X_WO.p, size.x, points_W);
        break;
      }
      const render::Mesh& mesh = assets->meshes[primitive.asset - 1];
      for (uint32_t i = 0; i < mesh.vertices.size(); ++i) add(mesh.place_of(i));
      break;
  }
  return points_W;
}

}  // namespace

Footprint footprint_of(const Primitive& primitive, const render::Assets* assets) {
  Footprint footprint;
  std::vector<Corner> corners;
  footprint.top_m = primitive.X_WO.p.z;
  for (const Vec3& p_W : points_of(primitive, assets)) {
    corners.push_back({p_W.x, p_W.y});
    footprint.top_m = std::max(footprint.top_m, p_W.z);
  }
  footprint.corners = hull_of(std::move(corners));
  return footprint;
}

}  // namespace seam::tools
