// What the process that reads a mesh file sends back.
#pragma once

#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "render/assets/assets.h"
#include "sim_core/base/error.h"

namespace seam::render {

struct PictureSource {
  std::string name;   // Relative to the mesh's file; empty where it is inside that file.
  std::string bytes;  // Then these.
};

struct ReadMesh {
  std::string error;  // Empty: all well.
  std::vector<MeshVertex> vertices;
  std::vector<uint32_t> indices;
  std::vector<MeshPart> parts;
  std::vector<PictureSource> pictures;
  std::vector<std::string> files;   // All that were read, relative to the folder.
  std::vector<std::string> missed;  // And those that were looked for and are not there.
};

class ByteWriter {
 public:
  template <typename Item>
  void add(const std::vector<Item>& items) {
    static_assert(std::is_trivially_copyable_v<Item>);
    add_raw(items.data(), items.size(), sizeof(Item));
  }
  void add(const std::string& text) { add_raw(text.data(), text.size(), 1); }
  void add(uint64_t value) { bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value)); }
  const std::string& bytes() const { return bytes_; }

 private:
  void add_raw(const void* data, size_t count, size_t each) {
    add(static_cast<uint64_t>(count));
    if (count > 0) bytes_.append(static_cast<const char*>(data), count * each);
  }
  std::string bytes_;
};

// Throws InputError at the end of the bytes.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}
  uint64_t number() {
    uint64_t value = 0;
    take(&value, 1, sizeof(value));
    return value;
  }
  template <typename Item>
  void read(std::vector<Item>& items) {
    items.resize(count_of(sizeof(Item)));
    take(items.data(), items.size(), sizeof(Item));
  }
  void read(std::string& text) {
    text.resize(count_of(1));
    take(text.data(), text.size(), 1);
  }

 private:
  size_t count_of(size_t each) {
    const uint64_t count = number();
    if (count > (bytes_.size() - at_) / each) throw InputError("its reader ended early");
    return count;
  }
  void take(void* out, size_t count, size_t each) {
    if (count * each > bytes_.size() - at_) throw InputError("its reader ended early");
    if (count > 0) std::memcpy(out, bytes_.data() + at_, count * each);
    at_ += count * each;
  }
  std::string_view bytes_;
  size_t at_ = 0;
};

// Finds the parts whose faces are flat and lets these share corners: STL files repeat each corner
// for each face.
void join_flat_faces(ReadMesh& mesh);

constexpr size_t kMostVertices = 8'000'000;

// ".stl", in lower case. Throws InputError where files of this ending are not read.
std::string mesh_ending(const std::string& name);

// Reads the file, whose bytes are given, by Assimp; runs in the process of its own.
ReadMesh import_mesh(const std::filesystem::path& folder, const std::string& name,
                     const std::string& bytes);
// Of Assimp, which decides with the bytes what a mesh becomes.
std::string mesh_library_version();

// The same in that process. `limits`: for its time.
ReadMesh import_mesh_apart(const std::filesystem::path& folder, const std::string& name,
                           const std::string& bytes, AssetLimits& limits);

}  // namespace seam::render
