#include "render/assets/closed_mesh.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/assets/mesh_clusters.h"
#include "sim_core/base/random.h"

namespace seam::render {
namespace {

// Every vertex anew for each triangle, as STL files have them.
void add(Mesh& mesh, const Vec3& a, const Vec3& b, const Vec3& c) {
  for (const Vec3& p : {a, b, c}) {
    MeshVertex vertex{};
    for (int k = 0; k < 3; ++k) vertex.p[k] = static_cast<float>(p[k]);
    mesh.indices.push_back(static_cast<uint32_t>(mesh.vertices.size()));
    mesh.vertices.push_back(vertex);
    mesh.radius_m = std::max(mesh.radius_m, std::sqrt(glm::dot(p, p)));
  }
}

// A surface of places at(s, t) that comes back to its start in both: counter-clockwise where its
// normal is that of rising s and t.
template <typename At>
Mesh ring_of(int around, int tube, const At& at) {
  Mesh mesh;
  const auto place = [&](int a, int b) {
    return at(6.283185307179586 * (a % around) / around, 6.283185307179586 * (b % tube) / tube);
  };
  for (int a = 0; a < around; ++a) {
    for (int b = 0; b < tube; ++b) {
      add(mesh, place(a, b), place(a + 1, b), place(a + 1, b + 1));
      add(mesh, place(a, b), place(a + 1, b + 1), place(a, b + 1));
    }
  }
  mesh.parts = {{.first = 0, .count = static_cast<uint32_t>(mesh.indices.size())}};
  return mesh;
}

Vec3 on_ring(double s, double t) {
  const double out = 0.2 + 0.08 * std::cos(t);
  return {out * std::cos(s), out * std::sin(s), 0.08 * std::sin(t)};
}

Mesh turned(Mesh mesh) {
  for (size_t i = 0; i < mesh.indices.size(); i += 3)
    std::swap(mesh.indices[i], mesh.indices[i + 1]);
  return mesh;
}

Mesh both(Mesh a, const Mesh& b, const Vec3& moved) {
  for (size_t i = 0; i < b.indices.size(); i += 3) {
    Vec3 p[3];
    for (size_t k = 0; k < 3; ++k) {
      const float* const at = b.vertices[b.indices[i + k]].p;
      p[k] = Vec3(at[0], at[1], at[2]) + moved;
    }
    add(a, p[0], p[1], p[2]);
  }
  return a;
}

TEST(ClosedMesh, TurnsAreThoseSeenFromOutside) {
  const Mesh ring = ring_of(24, 12, on_ring);
  EXPECT_EQ(turn_seen_from_outside(ring), 1);
  EXPECT_EQ(turn_seen_from_outside(turned(ring)), -1);
  EXPECT_EQ(turn_seen_from_outside(both(ring, ring, {0.1, 0.7, 0})), 1);
}

TEST(ClosedMesh, WhatShowsItsInsideHasNone) {
  const Mesh ring = ring_of(24, 12, on_ring);
  Mesh open = ring;
  open.indices.resize(open.indices.size() - 3);
  EXPECT_EQ(turn_seen_from_outside(open), 0);
  Mesh one_turned = ring;
  std::swap(one_turned.indices[30], one_turned.indices[31]);
  EXPECT_EQ(turn_seen_from_outside(one_turned), 0);
  EXPECT_EQ(turn_seen_from_outside(both(ring, turned(ring), {0.1, 0.7, 0})), 0);
  EXPECT_EQ(turn_seen_from_outside({}), 0);
}

// A tube along a figure of eight whose cross-section turns inside out on one side: all of its edges
// join two triangles that run alike, and it encloses more volume one way than the other.
TEST(ClosedMesh, ABodyThatTurnsInsideOutHasNone) {
  const Mesh twisted = ring_of(48, 12, [](double s, double t) {
    const double radius = 0.05 + 0.1 * std::cos(s);
    const double out = 0.3 + radius * std::cos(t);
    return Vec3(out * std::cos(s), out * std::sin(s), 0.08 * std::sin(t));
  });
  EXPECT_EQ(turn_seen_from_outside(twisted), 0);
}

// What is said to look away does so, triangle by triangle; and much is said to.
TEST(ClosedMesh, ClustersThatLookAwayShowNothing) {
  const Mesh ring = ring_of(60, 30, on_ring);
  std::vector<uint32_t> indices = ring.indices;
  const std::vector<MeshCluster> clusters = make_clusters(ring, ring.parts[0], indices);
  int away = 0;
  for (uint64_t trial = 0; trial < 50; ++trial) {
    const auto draw = [&](uint64_t k) { return 2 * uniform({.seed = 3, .stream = trial}, k) - 1; };
    const Vec3 camera = 1.5 * Vec3(draw(0), draw(1), draw(2));
    for (const MeshCluster& cluster : clusters) {
      EXPECT_FALSE(cluster.looks_away(camera, 1) && cluster.looks_away(camera, -1));
      if (!cluster.looks_away(camera, 1)) continue;
      away += static_cast<int>(cluster.count / 3);
      for (uint32_t i = cluster.first; i < cluster.first + cluster.count; i += 3) {
        Vec3 p[3];
        for (size_t k = 0; k < 3; ++k) {
          const float* const at = ring.vertices[indices[i + k]].p;
          p[k] = {at[0], at[1], at[2]};
        }
        EXPECT_LE(glm::dot(glm::cross(p[1] - p[0], p[2] - p[0]), camera - p[0]), 0);
      }
    }
  }
  EXPECT_GT(away, 50 * 3600 / 5);
}

}  // namespace
}  // namespace seam::render
