#include "render/gl/closed_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>

#include "sim_core/base/maths.h"

namespace seam::render::gl {
namespace {

using Triangle = std::array<uint32_t, 3>;

// For each vertex the first one at its place: files repeat corners whose normals differ.
std::vector<uint32_t> first_at_place(const Mesh& mesh) {
  std::vector<uint32_t> order(mesh.vertices.size()), first(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](uint32_t i) {
    const float* const p = mesh.vertices[i].p;
    return std::array<float, 3>{p[0], p[1], p[2]};
  };
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    const auto at_a = key(a), at_b = key(b);
    return at_a != at_b ? at_a < at_b : a < b;
  });
  for (size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

// Without those that have no area.
std::vector<Triangle> triangles_of(const Mesh& mesh) {
  const std::vector<uint32_t> first = first_at_place(mesh);
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.indices.size() / 3);
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const Triangle t{first[mesh.indices[i]], first[mesh.indices[i + 1]],
                     first[mesh.indices[i + 2]]};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
  }
  return triangles;
}

// Each edge has one triangle on either side, and they run alike.
bool closed(const std::vector<Triangle>& triangles) {
  // Of each edge: its ends, the smaller first, then the direction in which the triangle runs.
  std::vector<uint64_t> edges;
  edges.reserve(3 * triangles.size());
  for (const Triangle& t : triangles) {
    for (size_t k = 0; k < 3; ++k) {
      const uint64_t a = t[k], b = t[(k + 1) % 3];
      edges.push_back(a < b ? (a << 33) | (b << 1) : (b << 33) | (a << 1) | 1);
    }
  }
  std::sort(edges.begin(), edges.end());
  if (edges.empty() || edges.size() % 2 != 0) return false;
  for (size_t i = 0; i < edges.size(); i += 2) {
    const bool apart = i + 2 == edges.size() || edges[i + 2] >> 1 != edges[i] >> 1;
    if ((edges[i] ^ edges[i + 1]) != 1 || !apart) return false;
  }
  return true;
}

// Six times the volume that the triangles of each connected piece enclose.
std::vector<double> volumes(const Mesh& mesh, const std::vector<Triangle>& triangles) {
  std::vector<uint32_t> piece(mesh.vertices.size());
  std::iota(piece.begin(), piece.end(), 0);
  const auto find = [&](uint32_t i) {
    while (piece[i] != i) i = piece[i] = piece[piece[i]];
    return i;
  };
  for (const Triangle& t : triangles) {
    for (size_t k = 1; k < 3; ++k) piece[find(t[k])] = find(t[0]);
  }
  std::vector<double> of_piece(mesh.vertices.size());
  for (const Triangle& t : triangles) {
    const Vec3 a = mesh.place_of(t[0]), b = mesh.place_of(t[1]), c = mesh.place_of(t[2]);
    of_piece[find(t[0])] += glm::dot(a, glm::cross(b, c));
  }
  std::erase(of_piece, 0.0);
  return of_piece;
}

// The turn of the first triangle that a level or upright ray meets, 0 where it meets none.
int first_met(const Mesh& mesh, const std::vector<Triangle>& triangles, int axis, double a,
              double b, bool from_above) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  double nearest = -1e30;
  int turn = 0;
  for (const Triangle& t : triangles) {
    Vec3 p[3];
    double side[3];
    for (size_t k = 0; k < 3; ++k) p[k] = mesh.place_of(t[k]);
    for (size_t k = 0; k < 3; ++k) {
      const Vec3 &from = p[(k + 1) % 3], &to = p[(k + 2) % 3];
      side[k] = (to[u] - from[u]) * (b - from[v]) - (to[v] - from[v]) * (a - from[u]);
    }
    const bool left = side[0] > 0 && side[1] > 0 && side[2] > 0;
    const bool right = side[0] < 0 && side[1] < 0 && side[2] < 0;
    if (!left && !right) continue;
    const double along = (side[0] * p[0][axis] + side[1] * p[1][axis] + side[2] * p[2][axis]) /
                         (side[0] + side[1] + side[2]);
    const double height = from_above ? along : -along;
    if (height > nearest) nearest = height, turn = left == from_above ? 1 : -1;
  }
  return turn;
}

// A body that runs through itself may show its inside, though all its volume is counted right: rays
// from six sides try.
bool shows_this_turn(const Mesh& mesh, const std::vector<Triangle>& triangles, int turn) {
  constexpr double kTests = 4e7;
  const double wanted = std::sqrt(kTests / (6.0 * static_cast<double>(triangles.size())));
  const int across = static_cast<int>(std::clamp(wanted, 2.0, 8.0));
  for (int ray = 0; ray < 6 * across * across; ++ray) {
    const double a = (ray / 6 % across + 0.4871) / across * 2 - 1;
    const double b = (ray / 6 / across + 0.5237) / across * 2 - 1;
    const int met =
        first_met(mesh, triangles, ray % 3, a * mesh.radius_m, b * mesh.radius_m, ray / 3 % 2 == 0);
    if (met == -turn) return false;
  }
  return true;
}

}  // namespace

int turn_seen_from_outside(const Mesh& mesh) {
  const std::vector<Triangle> triangles = triangles_of(mesh);
  if (!closed(triangles)) return 0;
  const std::vector<double> volume = volumes(mesh, triangles);
  if (volume.empty()) return 0;
  const int turn = volume[0] > 0 ? 1 : -1;
  for (const double v : volume) {
    if (!(v * turn > 0)) return 0;
  }
  return shows_this_turn(mesh, triangles, turn) ? turn : 0;
}

}  // namespace seam::render::gl
