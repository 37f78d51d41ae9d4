// Meshes and pictures of a scene, as renderers take them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim_core/base/maths.h"
#include "sim_core/input/config_table.h"

namespace seam::render {

// Row-major, (0, 0) the top-left pixel; red, green, blue, 8 bits each, in sRGB.
struct Picture {
  int width_px = 0;
  int height_px = 0;
  std::vector<uint8_t> rgb;
};

// A corner of triangles. Places in metres; z is up.
struct MeshVertex {
  float p[3];
  float n[3];    // Unit normal.
  float uv[2];   // (0, 0) is the picture's top-left corner, (1, 1) the bottom-right one.
  float rgb[3];  // Linear, of vertex and material.
};

// Triangles of one material.
struct MeshPart {
  uint32_t first = 0, count = 0;  // Indices.
  int32_t picture = -1;           // Into Mesh::pictures; -1: none.
  int32_t flat = 0;               // 1: each face has its plane's normal, whatever its corners say.
};

struct Mesh {
  std::vector<MeshVertex> vertices;
  std::vector<uint32_t> indices;  // Three a triangle.
  std::vector<MeshPart> parts;
  std::vector<Picture> pictures;
  double radius_m = 0;      // No vertex is farther from the origin.
  std::string fingerprint;  // Of the files.

  Vec3 place_of(uint32_t vertex) const {
    const float* const p = vertices[vertex].p;
    return {p[0], p[1], p[2]};
  }
};

struct Texture {
  Picture picture;
  std::string fingerprint;
};

struct Assets {
  std::vector<Mesh> meshes;
  std::vector<Texture> textures;
};

inline constexpr int kMostTexturePixels = 16384;  // Along a side.
inline constexpr size_t kMostTriangles = 5'000'000;

// glTF 2.0 (.gltf, .glb), OBJ, STL and COLLADA, with the pictures that they name, all of them in
// the folder. glTF's and COLLADA's up becomes z. Throws InputError naming the file. The reading
// itself is done by a process of its own with bounded memory and time, for files come from anywhere
// and their readers have had holes.
Mesh read_mesh(const FileName& file, double scale);

// PNG or JPEG; `name` is what errors call it.
Picture decode_picture(const std::string& bytes, const std::string& name);
Texture read_texture(const FileName& file);

}  // namespace seam::render
