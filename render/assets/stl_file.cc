#include "render/assets/stl_file.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace seam::render {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr size_t kHeaderBytes = 84, kFacetBytes = 50;
constexpr uint16_t kHasColour = 0x8000;

struct Facet {
  float normal[3];
  float corner[3][3];
};

uint32_t facets_of(std::string_view bytes) {
  uint32_t facets = 0;
  if (bytes.size() >= kHeaderBytes) std::memcpy(&facets, bytes.data() + 80, sizeof facets);
  return facets;
}

Facet facet_at(std::string_view bytes, size_t place) {
  Facet facet;
  std::memcpy(&facet, bytes.data() + kHeaderBytes + kFacetBytes * place, sizeof facet);
  return facet;
}

bool has_colours(std::string_view bytes, size_t facets) {
  if (bytes.substr(0, 80).find("COLOR=") != std::string_view::npos) return true;
  for (size_t i = 0; i < facets; ++i) {
    uint16_t attribute = 0;
    std::memcpy(&attribute, bytes.data() + kHeaderBytes + kFacetBytes * i + sizeof(Facet), 2);
    if ((attribute & kHasColour) != 0) return true;
  }
  return false;
}

// Of length 1; zero where it is no direction.
void set_normal(const float* given, float* out) {
  const float length = std::sqrt(given[0] * given[0] + given[1] * given[1] + given[2] * given[2]);
  const bool is_direction = std::isfinite(length) && length > 1e-12f;
  const float share = is_direction ? 1.0f / length : 0.0f;
  for (int k = 0; k < 3; ++k) out[k] = is_direction ? given[k] * share : 0.0f;
}

// Vertices by their places and normals, each once, in the order of the file.
class Vertices {
 public:
  Vertices(size_t corners, std::vector<MeshVertex>& out)
      : slots_(std::bit_ceil(2 * corners + 2), kFree), out_(out) {}

  uint32_t add(const MeshVertex& vertex) {
    for (size_t at = hash(vertex);; ++at) {
      uint32_t& slot = slots_[at & (slots_.size() - 1)];
      if (slot != kFree && !same(out_[slot], vertex)) continue;
      if (slot == kFree) {
        slot = static_cast<uint32_t>(out_.size());
        out_.push_back(vertex);
      }
      return slot;
    }
  }

 private:
  static constexpr uint32_t kFree = 0xffffffff;
  static bool same(const MeshVertex& a, const MeshVertex& b) {
    return std::equal(a.p, a.p + 3, b.p) && std::equal(a.n, a.n + 3, b.n);
  }
  static size_t hash(const MeshVertex& vertex) {
    uint64_t sum = 0;
    const auto add = [&](float value) {
      sum = (sum ^ std::bit_cast<uint32_t>(value + 0.0f)) * 0x9e3779b97f4a7c15;
      sum ^= sum >> 29;
    };
    for (const float value : vertex.p) add(value);
    for (const float value : vertex.n) add(value);
    return sum;
  }
  std::vector<uint32_t> slots_;
  std::vector<MeshVertex>& out_;
};

}  // namespace

bool is_plain_stl(std::string_view bytes) {
  const uint32_t facets = facets_of(bytes);
  return facets > 0 && bytes.size() == kHeaderBytes + kFacetBytes * size_t{facets} &&
         !has_colours(bytes, facets);
}

ReadMesh read_plain_stl(std::string_view bytes) {
  const uint32_t facets = facets_of(bytes);
  if (facets > kMostTriangles)
    throw InputError(
        fmt::format("found {} triangles, expected at most {}", facets, kMostTriangles));
  ReadMesh mesh;
  mesh.indices.reserve(size_t{3} * facets);
  Vertices vertices(size_t{3} * facets, mesh.vertices);
  for (size_t i = 0; i < facets; ++i) {
    const Facet facet = facet_at(bytes, i);
    MeshVertex vertex{.p = {}, .n = {}, .uv = {}, .rgb = {1, 1, 1}};
    set_normal(facet.normal, vertex.n);
    for (size_t k = 0; k < 3; ++k) {
      for (size_t axis = 0; axis < 3; ++axis) {
        vertex.p[axis] = facet.corner[k][axis];
        if (!std::isfinite(vertex.p[axis]))
          throw InputError(
              fmt::format("corner {} of triangle {} is not finite, expected numbers", k, i));
      }
      mesh.indices.push_back(vertices.add(vertex));
    }
  }
  mesh.parts = {{.first = 0, .count = 3 * facets}};
  join_flat_faces(mesh);
  return mesh;
}

}  // namespace seam::render
