#include "app/asset_reader.h"

namespace seam::app {

uint32_t AssetReader::mesh(FileName& file, double scale) {
  const auto [place, is_new] = meshes_.of(file, scale);
  if (is_new) assets_.meshes.push_back(files_.mesh(file, scale));
  file.fingerprint = assets_.meshes[place - 1].fingerprint;
  return place;
}

uint32_t AssetReader::texture(FileName& file) {
  const auto [place, is_new] = textures_.of(file);
  if (is_new) assets_.textures.push_back(files_.texture(file));
  file.fingerprint = assets_.textures[place - 1].fingerprint;
  return place;
}

}  // namespace seam::app
