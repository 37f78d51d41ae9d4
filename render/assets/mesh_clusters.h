// Triangles in groups that lie together, so that a band of the film strip draws those that it can
// see and not the whole mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "render/assets/assets.h"

namespace seam::render {

// Puts the part's indices in an order in which triangles that lie together follow each other.
std::vector<MeshCluster> make_clusters(const Mesh& mesh, const MeshPart& part,
                                       std::vector<uint32_t>& indices);

// Makes Mesh::prepared, and the order of the indices that belongs to it, where it is not there.
void prepare_mesh(Mesh& mesh);

}  // namespace seam::render
