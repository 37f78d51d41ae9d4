// A scene's meshes and textures as bytes, for renderers elsewhere that have none of its files.
#pragma once

#include <string>

#include "render/assets/mesh_bytes.h"

namespace seam::render {

inline void add_picture(const Picture& picture, ByteWriter& bytes) {
  bytes.add(static_cast<uint64_t>(picture.width_px));
  bytes.add(static_cast<uint64_t>(picture.height_px));
  bytes.add(picture.rgb);
}

inline Picture read_picture(ByteReader& bytes) {
  const uint64_t width = bytes.number(), height = bytes.number();
  Picture picture;
  bytes.read(picture.rgb);
  if (width > kMostTexturePixels || height > kMostTexturePixels ||
      picture.rgb.size() != 3 * width * height)
    throw InputError(fmt::format("assets: found a picture of {}x{} in {} bytes", width, height,
                                 picture.rgb.size()));
  picture.width_px = static_cast<int>(width), picture.height_px = static_cast<int>(height);
  return picture;
}

inline std::string bytes_of(const Assets& assets) {
  ByteWriter bytes;
  bytes.add(static_cast<uint64_t>(assets.meshes.size()));
  for (const Mesh& mesh : assets.meshes) {
    bytes.add(mesh.vertices), bytes.add(mesh.indices), bytes.add(mesh.parts);
    bytes.add(static_cast<uint64_t>(mesh.pictures.size()));
    for (const auto& picture : mesh.pictures) add_picture(*picture, bytes);
  }
  bytes.add(static_cast<uint64_t>(assets.textures.size()));
  for (const Texture& texture : assets.textures) add_picture(*texture.picture, bytes);
  return bytes.bytes();
}

// Throws InputError where the bytes are no assets.
inline Assets assets_of(const std::string& text) {
  ByteReader bytes(text);
  Assets assets;
  for (uint64_t left = bytes.number(); left > 0; --left) {
    Mesh mesh;
    bytes.read(mesh.vertices), bytes.read(mesh.indices), bytes.read(mesh.parts);
    for (uint64_t pictures = bytes.number(); pictures > 0; --pictures)
      mesh.pictures.push_back(std::make_shared<const Picture>(read_picture(bytes)));
    for (const uint32_t index : mesh.indices) {
      if (index >= mesh.vertices.size()) throw InputError("assets: an index beyond the vertices");
    }
    for (const MeshPart& part : mesh.parts) {
      if (uint64_t{part.first} + part.count > mesh.indices.size() ||
          part.picture >= static_cast<int64_t>(mesh.pictures.size()))
        throw InputError("assets: a part beyond its mesh");
    }
    assets.meshes.push_back(std::move(mesh));
  }
  for (uint64_t left = bytes.number(); left > 0; --left)
    assets.textures.push_back({std::make_shared<const Picture>(read_picture(bytes)), ""});
  return assets;
}

}  // namespace seam::render
