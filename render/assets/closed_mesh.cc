#include "render/assets/closed_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

#include "sim_core/base/maths.h"

namespace seam::render {
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

// Rays along one axis, from above and from below, at places that stand in a square.
class Rays {
 public:
  Rays(const Mesh& mesh, size_t axis)
      : mesh_(mesh), axis_(axis), u_((axis + 1) % 3), v_((axis + 2) % 3) {}

  void meet(const Triangle& t) {
    const Vec3 p[3] = {mesh_.place_of(t[0]), mesh_.place_of(t[1]), mesh_.place_of(t[2])};
    const auto [first_a, last_a] = near(p[0][u_], p[1][u_], p[2][u_], kAlong);
    const auto [first_b, last_b] = near(p[0][v_], p[1][v_], p[2][v_], kAcross);
    for (int j = first_b; j <= last_b; ++j)
      for (int i = first_a; i <= last_a; ++i) meet(p, i, j);
  }
  // Whether some ray meets a triangle that runs so before all others.
  bool saw(int turn) const {
    return std::any_of(rays_.begin(), rays_.end(), [&](const std::array<Met, 2>& both) {
      return both[0].turn == turn || both[1].turn == turn;
    });
  }

 private:
  static constexpr int kAside = 8;
  static constexpr double kAlong = 0.4871, kAcross = 0.5237;  // Where edges hardly ever are.
  struct Met {
    double height = -1e30;
    int turn = 0;
  };

  double place(int i, double shift) const {
    return ((i + shift) / kAside * 2 - 1) * mesh_.radius_m;
  }
  // The places that three values may lie around.
  std::pair<int, int> near(double a, double b, double c, double shift) const {
    const auto index = [&](double x) {
      return static_cast<int>(std::floor((x / mesh_.radius_m + 1) / 2 * kAside - shift));
    };
    return {std::max(0, index(std::min({a, b, c}))),
            std::min(kAside - 1, index(std::max({a, b, c})) + 1)};
  }
  void meet(const Vec3 (&p)[3], int i, int j) {
    const double a = place(i, kAlong), b = place(j, kAcross);
    double side[3];
    for (size_t k = 0; k < 3; ++k) {
      const Vec3 &from = p[(k + 1) % 3], &to = p[(k + 2) % 3];
      side[k] = (to[u_] - from[u_]) * (b - from[v_]) - (to[v_] - from[v_]) * (a - from[u_]);
    }
    const bool left = side[0] > 0 && side[1] > 0 && side[2] > 0;
    const bool right = side[0] < 0 && side[1] < 0 && side[2] < 0;
    if (!left && !right) return;
    const double along = (side[0] * p[0][axis_] + side[1] * p[1][axis_] + side[2] * p[2][axis_]) /
                         (side[0] + side[1] + side[2]);
    std::array<Met, 2>& both = rays_[static_cast<size_t>(j * kAside + i)];
    if (along > both[0].height) both[0] = {along, left ? 1 : -1};
    if (-along > both[1].height) both[1] = {-along, left ? -1 : 1};
  }

  const Mesh& mesh_;
  size_t axis_, u_, v_;
  std::array<std::array<Met, 2>, kAside * kAside> rays_;  // From above, from below.
};

// A body that runs through itself may show its inside, though all its volume is counted right: rays
// from six sides try.
bool shows_this_turn(const Mesh& mesh, const std::vector<Triangle>& triangles, int turn) {
  for (size_t axis = 0; axis < 3; ++axis) {
    Rays rays(mesh, axis);
    for (const Triangle& t : triangles) rays.meet(t);
    if (rays.saw(-turn)) return false;
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

}  // namespace seam::render
