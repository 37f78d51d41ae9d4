// Triangles in groups that lie together, so that a band of the film strip draws those that it can
// see and not the whole mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "render/assets/assets.h"
#include "sim_core/base/maths.h"

namespace seam::render::gl {

// A run of indices, and a ball around its triangles and a cone around their normals.
struct MeshCluster {
  uint32_t first = 0, count = 0;
  Vec3 centre{0.0};
  double radius = 0;
  Vec3 normal{0.0};    // Of triangles that run counter-clockwise.
  double spread = 10;  // The sine of the angle from `normal` to any; 10 where that is not acute.

  // Whether a camera here sees no triangle's side from which it runs counter-clockwise (turn 1), or
  // clockwise (turn -1).
  bool looks_away(const Vec3& camera, int turn) const;
};

// Puts the part's indices in an order in which triangles that lie together follow each other.
std::vector<MeshCluster> make_clusters(const Mesh& mesh, const MeshPart& part,
                                       std::vector<uint32_t>& indices);

}  // namespace seam::render::gl
