#include "render/assets/mesh_clusters.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/assets/closed_mesh.h"

namespace seam::render {
namespace {

// Fewer would cost more in calls than they save in triangles.
constexpr size_t kTriangles = 48;

using Triangle = std::array<uint32_t, 3>;

// Thrice the middle.
Vec3 middle(const Mesh& mesh, const Triangle& triangle) {
  return mesh.place_of(triangle[0]) + mesh.place_of(triangle[1]) + mesh.place_of(triangle[2]);
}

// Of what has no area the normal does not matter.
void add_cone(const Mesh& mesh, const std::vector<Triangle>& triangles, size_t begin, size_t end,
              MeshCluster& cluster) {
  const auto normal_of = [&](const Triangle& t) {
    const Vec3 a = mesh.place_of(t[0]);
    const Vec3 n = glm::cross(mesh.place_of(t[1]) - a, mesh.place_of(t[2]) - a);
    const double length = std::sqrt(glm::dot(n, n));
    return length > 0 ? n / length : Vec3(0.0);
  };
  Vec3 sum(0.0);
  for (size_t i = begin; i < end; ++i) sum += normal_of(triangles[i]);
  const double length = std::sqrt(glm::dot(sum, sum));
  if (!(length > 0)) return;
  cluster.normal = sum / length;
  double least = 1;
  for (size_t i = begin; i < end; ++i) {
    const Vec3 n = normal_of(triangles[i]);
    if (n != Vec3(0.0)) least = std::min(least, glm::dot(n, cluster.normal));
  }
  constexpr double kRounding = 1e-6;
  if (least > 0.01) cluster.spread = std::sqrt(std::max(0.0, 1 - least * least)) + kRounding;
}

MeshCluster cluster_of(const Mesh& mesh, const std::vector<Triangle>& triangles, size_t begin,
                       size_t end) {
  Vec3 low(1e30), high(-1e30);
  for (size_t i = begin; i < end; ++i) {
    for (const uint32_t vertex : triangles[i])
      low = glm::min(low, mesh.place_of(vertex)), high = glm::max(high, mesh.place_of(vertex));
  }
  MeshCluster cluster{.count = static_cast<uint32_t>(3 * (end - begin)),
                      .centre = 0.5 * (low + high)};
  for (size_t i = begin; i < end; ++i) {
    for (const uint32_t vertex : triangles[i]) {
      const Vec3 away = mesh.place_of(vertex) - cluster.centre;
      cluster.radius = std::max(cluster.radius, std::sqrt(glm::dot(away, away)));
    }
  }
  add_cone(mesh, triangles, begin, end, cluster);
  return cluster;
}

// Halves along the longest side until groups are small; these are in one order whatever was given,
// so that a mesh sent elsewhere in its clusters' order is drawn there in the same.
void split(const Mesh& mesh, std::vector<Triangle>& triangles, size_t begin, size_t end,
           std::vector<MeshCluster>& out) {
  if (end - begin <= kTriangles) {
    std::sort(triangles.begin() + static_cast<ptrdiff_t>(begin),
              triangles.begin() + static_cast<ptrdiff_t>(end));
    out.push_back(cluster_of(mesh, triangles, begin, end));
    return;
  }
  Vec3 low(1e30), high(-1e30);
  for (size_t i = begin; i < end; ++i) {
    const Vec3 at = middle(mesh, triangles[i]);
    low = glm::min(low, at), high = glm::max(high, at);
  }
  const Vec3 side = high - low;
  const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
  const size_t half = begin + (end - begin) / 2;
  const auto first = triangles.begin();
  std::nth_element(first + static_cast<ptrdiff_t>(begin), first + static_cast<ptrdiff_t>(half),
                   first + static_cast<ptrdiff_t>(end), [&](const Triangle& a, const Triangle& b) {
                     const double at_a = middle(mesh, a)[axis], at_b = middle(mesh, b)[axis];
                     return at_a != at_b ? at_a < at_b : a < b;
                   });
  split(mesh, triangles, begin, half, out);
  split(mesh, triangles, half, end, out);
}

}  // namespace

bool MeshCluster::looks_away(const Vec3& camera, int turn) const {
  // The way to any point of the ball turns from that to its centre by asin(radius / distance).
  const Vec3 way = centre - camera;
  return turn * glm::dot(normal, way) > spread * std::sqrt(glm::dot(way, way)) + radius;
}

std::vector<MeshCluster> make_clusters(const Mesh& mesh, const MeshPart& part,
                                       std::vector<uint32_t>& indices) {
  std::vector<Triangle> triangles(part.count / 3);
  for (size_t i = 0; i < triangles.size(); ++i) {
    for (size_t k = 0; k < 3; ++k) triangles[i][k] = indices[part.first + 3 * i + k];
  }
  std::vector<MeshCluster> clusters;
  if (triangles.empty()) return clusters;
  split(mesh, triangles, 0, triangles.size(), clusters);
  for (size_t i = 0; i < triangles.size(); ++i) {
    for (size_t k = 0; k < 3; ++k) indices[part.first + 3 * i + k] = triangles[i][k];
  }
  uint32_t first = part.first;
  for (MeshCluster& cluster : clusters) cluster.first = first, first += cluster.count;
  return clusters;
}

void prepare_mesh(Mesh& mesh) {
  if (mesh.prepared) return;
  PreparedMesh made{.clusters = {}, .turn = turn_seen_from_outside(mesh)};
  for (const MeshPart& part : mesh.parts)
    made.clusters.push_back(make_clusters(mesh, part, mesh.indices));
  mesh.prepared = std::move(made);
}

}  // namespace seam::render
