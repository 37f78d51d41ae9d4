// Meshes and pictures of a scene, as renderers take them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
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

// Triangles that lie together, so that a band of the film strip draws those that it can see and not
// the whole mesh: a run of indices, and a ball around its triangles and a cone around their
// normals.
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

// What drawing needs of a mesh beside its triangles.
struct PreparedMesh {
  std::vector<std::vector<MeshCluster>> clusters;  // Of each part.
  int turn = 0;                                    // As turn_seen_from_outside.
};

struct Mesh {
  std::vector<MeshVertex> vertices;
  std::vector<uint32_t> indices;  // Three a triangle.
  std::vector<MeshPart> parts;
  std::vector<std::shared_ptr<const Picture>> pictures;  // Meshes of one file's picture share it.
  double radius_m = 0;                                   // No vertex is farther from the origin.
  std::string fingerprint;                               // Of the files.
  std::vector<std::string> files;        // Its own and those that it names, in its folder.
  std::optional<PreparedMesh> prepared;  // By prepare_mesh: indices are in the clusters' order.

  Vec3 place_of(uint32_t vertex) const {
    const float* const p = vertices[vertex].p;
    return {p[0], p[1], p[2]};
  }
};

struct Texture {
  std::shared_ptr<const Picture> picture;
  std::string fingerprint;
};

struct Assets {
  std::vector<Mesh> meshes;
  std::vector<Texture> textures;
};

inline constexpr int kMostTexturePixels = 16384;  // Along a side.
inline constexpr size_t kMostTriangles = 5'000'000;

// What the files of one scene may hold, all together: names of the same file and files that unpack
// to far more than they are long must cost no more than an honest scene does.
class AssetLimits {
 public:
  static constexpr uint64_t kMostPixels = 64'000'000;
  static constexpr uint64_t kMostBytes = uint64_t{1} << 30;
  static constexpr double kMostReaderSeconds = 20;

  // Each throws InputError where it is too much. `cost`: how many times the memory of a plain
  // picture its decoder takes.
  void take_picture(uint64_t width_px, uint64_t height_px, uint64_t cost, const std::string& name);
  void take_triangles(uint64_t count);
  void take_bytes(uint64_t count);
  // Of the processor, for files that other people's code reads.
  double reader_seconds_left() const { return kMostReaderSeconds - reader_seconds_; }
  void take_reader_seconds(double seconds) { reader_seconds_ += seconds; }

 private:
  uint64_t pixels_ = 0, triangles_ = 0, bytes_ = 0;
  double reader_seconds_ = 0;
};

// Whether this build reads meshes and textures at all.
bool reads_assets();

// The files of one scene, all within its limits. Throws InputError naming the file.
class AssetFiles {
 public:
  // glTF 2.0 (.gltf, .glb), OBJ, STL and COLLADA, with the pictures that they name, all of them in
  // the folder. glTF's and COLLADA's up becomes z. Files are read by a process of its own with
  // bounded memory and time, for they come from anywhere and their readers have had holes. What was
  // made of a mesh is kept in a cache (mesh_cache.h).
  Mesh mesh(const FileName& file, double scale);
  // PNG or JPEG.
  Texture texture(const FileName& file);

 private:
  friend class MeshMaker;
  std::shared_ptr<const Picture> picture(const std::string& canonical, const std::string& bytes,
                                         const std::string& name);
  AssetLimits limits_;
  std::map<std::string, std::shared_ptr<const Picture>> pictures_;  // By the file behind all links.
};

// Of a scene with this file alone.
inline Mesh read_mesh(const FileName& file, double scale) {
  return AssetFiles().mesh(file, scale);
}
inline Texture read_texture(const FileName& file) {
  return AssetFiles().texture(file);
}

// `name` is what errors call it.
Picture decode_picture(const std::string& bytes, const std::string& name, AssetLimits& limits);

}  // namespace seam::render
