#include "render/assets/assets_bytes.h"

#include <gtest/gtest.h>

namespace seam::render {
namespace {

Assets some_assets() {
  Mesh mesh;
  for (int i = 0; i < 4; ++i)
    mesh.vertices.push_back(
        {.p = {0.5f * i, 1, -2}, .n = {0, 0, 1}, .uv = {0, 1}, .rgb = {1, 0, 0}});
  mesh.indices = {0, 1, 2, 2, 1, 3};
  mesh.parts = {{.first = 0, .count = 3}, {.first = 3, .count = 3, .picture = 0}};
  mesh.pictures.push_back(std::make_shared<Picture>(Picture{2, 1, {1, 2, 3, 4, 5, 6}}));
  Assets assets;
  assets.meshes.push_back(mesh);
  assets.textures.push_back(
      {std::make_shared<Picture>(Picture{1, 2, {9, 8, 7, 6, 5, 4}}), "fingerprint"});
  return assets;
}

TEST(AssetsBytes, ComeBackAsTheyWere) {
  const Assets back = assets_of(bytes_of(some_assets()));
  ASSERT_EQ(back.meshes.size(), 1u);
  const Mesh& mesh = back.meshes[0];
  ASSERT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.vertices[3].p[0], 1.5f);
  EXPECT_EQ(mesh.indices, (std::vector<uint32_t>{0, 1, 2, 2, 1, 3}));
  ASSERT_EQ(mesh.parts.size(), 2u);
  EXPECT_EQ(mesh.parts[1].picture, 0);
  ASSERT_EQ(mesh.pictures.size(), 1u);
  EXPECT_EQ(mesh.pictures[0]->width_px, 2);
  ASSERT_EQ(back.textures.size(), 1u);
  EXPECT_EQ(back.textures[0].picture->rgb, (std::vector<uint8_t>{9, 8, 7, 6, 5, 4}));
}

TEST(AssetsBytes, BrokenOnesAreRefused) {
  const std::string bytes = bytes_of(some_assets());
  for (size_t length = 0; length < bytes.size(); ++length)
    EXPECT_THROW(assets_of(bytes.substr(0, length)), InputError) << length;
  Assets beyond = some_assets();
  beyond.meshes[0].indices[5] = 4;
  EXPECT_THROW(assets_of(bytes_of(beyond)), InputError);
  beyond = some_assets();
  beyond.meshes[0].parts[1].count = 6;
  EXPECT_THROW(assets_of(bytes_of(beyond)), InputError);
  beyond = some_assets();
  beyond.meshes[0].parts[1].picture = 1;
  EXPECT_THROW(assets_of(bytes_of(beyond)), InputError);
  beyond = some_assets();
  beyond.textures[0].picture = std::make_shared<Picture>(Picture{1, 3, {9, 8, 7, 6, 5, 4}});
  EXPECT_THROW(assets_of(bytes_of(beyond)), InputError);
}

}  // namespace
}  // namespace seam::render
