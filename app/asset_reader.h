// Reads the meshes and textures that objects name, each file once.
#pragma once

#include "render/assets/assets.h"
#include "sim_core/scene/drawn_files.h"

namespace seam::app {

class AssetReader {
 public:
  // Places from 1 on. What was not read yet is read, and its fingerprint left with its name.
  uint32_t mesh(FileName& file, double scale);
  uint32_t texture(FileName& file);
  double radius_m(uint32_t mesh) const { return assets_.meshes[mesh - 1].radius_m; }
  render::Assets take() { return std::move(assets_); }

 private:
  render::Assets assets_;
  render::AssetFiles files_;
  FilePlaces meshes_, textures_;
};

}  // namespace seam::app
