// STL by our own reader, and the cache of what was made of meshes.
#include "render/assets/mesh_cache.h"

#include <gmock/gmock.h>

#include "render/assets/asset_files_testing.h"
#include "render/assets/mesh_bytes.h"
#include "render/assets/stl_file.h"
#include "sim_core/base/files.h"

namespace seam::render {
namespace {

// ---- STL by our own reader ----

void expect_same(const ReadMesh& a, const ReadMesh& b) {
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  EXPECT_EQ(
      std::memcmp(a.vertices.data(), b.vertices.data(), a.vertices.size() * sizeof(MeshVertex)), 0);
  EXPECT_EQ(a.indices, b.indices);
  ASSERT_EQ(a.parts.size(), b.parts.size());
  EXPECT_EQ(a.parts[0].flat, b.parts[0].flat);
}

TEST_F(AssetFilesTest, PlainStlIsWhatAssimpMakesOfIt) {
  std::string crooked = binary_stl(57);
  const float normal[3] = {1, 2, 3};  // Not that of its plane.
  std::memcpy(&crooked[84 + 50 * 7], normal, sizeof normal);
  for (const std::string& bytes : {binary_stl(57), crooked}) {
    ASSERT_TRUE(is_plain_stl(bytes));
    put("own.stl", bytes);
    AssetLimits limits;
    expect_same(read_plain_stl(bytes), import_mesh_apart(folder_, "own.stl", bytes, limits));
  }
  EXPECT_FALSE(is_plain_stl(binary_stl(57) + "x"));
  EXPECT_FALSE(is_plain_stl(binary_stl(57, 0x8001)));  // Coloured.
  EXPECT_FALSE(is_plain_stl(""));
}

// ---- The cache ----

class MeshCacheTest : public AssetFilesTest {
 protected:
  MeshCacheTest() { setenv("SEAM_CACHE", (folder_ / "cache").c_str(), 1); }
  std::vector<fs::path> entries() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder_ / "cache/meshes"))
      found.push_back(entry.path());
    return found;
  }
};

void expect_same(const Mesh& a, const Mesh& b) {
  EXPECT_EQ(a.indices, b.indices);
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  EXPECT_EQ(
      std::memcmp(a.vertices.data(), b.vertices.data(), a.vertices.size() * sizeof(MeshVertex)), 0);
  EXPECT_EQ(a.radius_m, b.radius_m);
  EXPECT_EQ(a.fingerprint, b.fingerprint);
  ASSERT_TRUE(a.prepared && b.prepared);
  EXPECT_EQ(a.prepared->turn, b.prepared->turn);
  ASSERT_EQ(a.prepared->clusters.size(), b.prepared->clusters.size());
  for (size_t i = 0; i < a.prepared->clusters.size(); ++i) {
    const auto &one = a.prepared->clusters[i], &other = b.prepared->clusters[i];
    ASSERT_EQ(one.size(), other.size());
    EXPECT_EQ(std::memcmp(one.data(), other.data(), one.size() * sizeof(MeshCluster)), 0);
  }
}

TEST_F(MeshCacheTest, WhatIsKeptIsWhatWasMade) {
  put("m.mtl", "newmtl a\nKd 1 0 0\n");
  const FileName obj = put("m.obj", "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const FileName stl = put("m.stl", binary_stl(300));
  for (const FileName& file : {obj, stl}) {
    const Mesh first = read_mesh(file, 0.1);
    expect_same(first, read_mesh(file, 0.1));
  }
  EXPECT_EQ(entries().size(), 2u);
  read_mesh(stl, 0.2);  // Another mesh.
  EXPECT_EQ(entries().size(), 3u);
  setenv("SEAM_CACHE", "off", 1);
  const Mesh without = read_mesh(obj, 0.1);
  setenv("SEAM_CACHE", (folder_ / "cache").c_str(), 1);
  expect_same(without, read_mesh(obj, 0.1));
}

TEST_F(MeshCacheTest, FilesThatTheMeshNamesCount) {
  const FileName obj = put("m.obj", "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto green = [&] { return read_mesh(obj, 1).vertices[0].rgb[1]; };
  const float without = green();
  put("m.mtl", "newmtl a\nKd 1 0.25 0\n");  // It was not there.
  EXPECT_EQ(green(), 0.25f);
  EXPECT_NE(without, 0.25f);
  put("m.mtl", "newmtl a\nKd 1 0.5 0\n");
  EXPECT_EQ(green(), 0.5f);
  fs::remove(folder_ / "m.mtl");
  EXPECT_EQ(green(), without);
}

TEST_F(MeshCacheTest, DamagedAndForgedEntriesAreMadeAnew) {
  const FileName file = put("m.stl", binary_stl(40));
  const Mesh good = read_mesh(file, 1);
  ASSERT_EQ(entries().size(), 1u);
  const fs::path entry = entries()[0];
  const std::string bytes = read_file(entry), key = entry.filename().string();
  const MeshCache cache(folder_ / "cache/meshes");
  const std::string content = cache.find(key).value();
  // Each byte of the file is covered by the checksum.
  for (size_t i = 0; i < bytes.size(); i += 7) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x20);
    write_file_atomically(entry, damaged);
    EXPECT_FALSE(cache.find(key)) << i;
  }
  for (const size_t length : {size_t{0}, size_t{5}, bytes.size() - 1}) {
    write_file_atomically(entry, bytes.substr(0, length));
    expect_same(good, read_mesh(file, 1));
  }
  // With a checksum that is right: numbers that lead anywhere are not followed.
  for (size_t i = 0; i + 8 <= content.size(); i += 4) {
    for (const uint64_t number : {~uint64_t{0}, uint64_t{1} << 31, uint64_t{7}}) {
      std::string forged = content;
      std::memcpy(&forged[i], &number, i % 8 == 0 ? 8 : 4);
      cache.store(key, forged);
      const Mesh found = read_mesh(file, 1);
      for (const uint32_t index : found.indices) ASSERT_LT(index, found.vertices.size());
      for (const MeshPart& part : found.parts)
        ASSERT_LE(uint64_t{part.first} + part.count, found.indices.size());
      ASSERT_EQ(found.prepared->clusters.size(), found.parts.size());
      for (const MeshCluster& cluster : found.prepared->clusters[0])
        ASSERT_LE(uint64_t{cluster.first} + cluster.count, found.indices.size());
    }
  }
  for (const size_t length : {size_t{0}, size_t{9}, content.size() - 1}) {
    cache.store(key, content.substr(0, length));
    expect_same(good, read_mesh(file, 1));
  }
}

TEST_F(MeshCacheTest, ItsSizeIsBoundedAndItMayBeDeleted) {
  const MeshCache cache(folder_ / "small", 1000);
  for (int i = 0; i < 10; ++i) {
    const std::string key = fmt::format("k{}", i);
    cache.store(key, std::string(300, 'x'));
    // Times of files may be coarse.
    const fs::path path = folder_ / "small" / key;
    fs::last_write_time(path, fs::last_write_time(path) - std::chrono::seconds(100 - i));
  }
  uint64_t sum = 0;
  for (const auto& entry : fs::directory_iterator(folder_ / "small")) sum += entry.file_size();
  EXPECT_LE(sum, 1000u);
  EXPECT_TRUE(cache.find("k9"));
  EXPECT_FALSE(cache.find("k0"));
  cache.store("huge", std::string(2000, 'x'));
  EXPECT_FALSE(cache.find("huge"));
  fs::remove_all(folder_ / "small");
  EXPECT_FALSE(cache.find("k9"));
  // A folder that cannot be made is none.
  put("file", "");
  const MeshCache none(folder_ / "file" / "below");
  none.store("k", "x");
  EXPECT_FALSE(none.find("k"));
}

}  // namespace
}  // namespace seam::render
