#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "render/assets/mesh_bytes.h"
#include "sim_core/base/maths.h"

namespace seam::render {
namespace {

Vec3 place_of(const MeshVertex& vertex) {
  return {vertex.p[0], vertex.p[1], vertex.p[2]};
}

// Whether all corners of each face have the normal of its plane, or none that is a normal's.
bool is_flat(const ReadMesh& mesh, const MeshPart& part) {
  constexpr double kSame = 0.9999;  // 0.8 degrees.
  for (uint32_t i = part.first; i < part.first + part.count; i += 3) {
    const auto corner = [&](uint32_t k) -> const MeshVertex& {
      return mesh.vertices[mesh.indices[i + k]];
    };
    const Vec3 a = place_of(corner(0));
    const Vec3 across = glm::cross(place_of(corner(1)) - a, place_of(corner(2)) - a);
    const double length = std::sqrt(glm::dot(across, across));
    for (uint32_t k = 0; k < 3 && length > 0; ++k) {
      const Vec3 n(corner(k).n[0], corner(k).n[1], corner(k).n[2]);
      if (n != Vec3(0.0) && std::abs(glm::dot(n, across)) < kSame * length) return false;
    }
  }
  return true;
}

// All of a corner but its normal.
std::array<float, 8> key_of(const MeshVertex& v) {
  return {v.p[0], v.p[1], v.p[2], v.uv[0], v.uv[1], v.rgb[0], v.rgb[1], v.rgb[2]};
}

// Corners that differ by their normals alone become one.
void join_corners(ReadMesh& mesh, const MeshPart& part, std::vector<MeshVertex>& joined) {
  const auto begin = mesh.indices.begin() + part.first, end = begin + part.count;
  std::vector<uint32_t> order(begin, end);
  std::sort(order.begin(), order.end());
  order.erase(std::unique(order.begin(), order.end()), order.end());
  const std::vector<uint32_t> used = order;
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    const auto at_a = key_of(mesh.vertices[a]), at_b = key_of(mesh.vertices[b]);
    return at_a != at_b ? at_a < at_b : a < b;
  });
  std::vector<uint32_t> place(used.size());  // Of the part's corners in ascending order.
  const auto rank = [&](uint32_t vertex) {
    return std::lower_bound(used.begin(), used.end(), vertex) - used.begin();
  };
  for (size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || key_of(mesh.vertices[order[i]]) != key_of(mesh.vertices[order[i - 1]]))
      joined.push_back(mesh.vertices[order[i]]);
    place[rank(order[i])] = static_cast<uint32_t>(joined.size()) - 1;
  }
  for (auto index = begin; index != end; ++index) *index = place[rank(*index)];
}

}  // namespace

void join_flat_faces(ReadMesh& mesh) {
  std::vector<MeshVertex> joined;
  for (MeshPart& part : mesh.parts) {
    part.flat = is_flat(mesh, part) ? 1 : 0;
    if (part.flat == 0) {
      // As they are; a part has vertices of its own.
      const auto begin = mesh.indices.begin() + part.first, end = begin + part.count;
      const auto [low, high] = std::minmax_element(begin, end);
      const uint32_t first = *low, last = *high;
      const auto moved = static_cast<uint32_t>(joined.size()) - first;
      for (uint32_t i = first; i <= last; ++i) {
        MeshVertex& vertex = joined.emplace_back(mesh.vertices[i]);
        if (Vec3(vertex.n[0], vertex.n[1], vertex.n[2]) == Vec3(0.0)) vertex.n[2] = 1;
      }
      for (auto index = begin; index != end; ++index) *index += moved;
    } else {
      join_corners(mesh, part, joined);
    }
  }
  mesh.vertices = std::move(joined);
}

}  // namespace seam::render
