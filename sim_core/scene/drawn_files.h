// The meshes and textures that objects name: their keys in scenarios and scenes, and which of the
// files of one sort each is.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "sim_core/input/config_table.h"

namespace seam {

// The keys `file` and `scale` of a mesh.
inline void describe_mesh_file(ConfigTable& table, bool required, FileName& file, double& scale) {
  table.file_name(
      {"file", "Of a mesh: a glTF, OBJ, STL or COLLADA file in the folder of what names it.",
       required},
      file);
  table.number({"scale", "Of a mesh: metres for a unit of its file."}, scale, {1e-6, 1e6});
}

inline void describe_texture(ConfigTable& table, FileName& file) {
  table.file_name(
      {"texture", "Of a rectangle or box: a PNG or JPEG file in the folder of what names it."},
      file);
}

// The files of one sort, each once whatever it is called: their places, from 1 on.
class FilePlaces {
 public:
  struct Place {
    uint32_t place;
    bool is_new;
  };
  Place of(const FileName& file, double scale = 1) {
    const std::filesystem::path path = std::filesystem::path(file.folder) / file.name;
    const auto next = static_cast<uint32_t>(places_.size()) + 1;
    const auto [found, is_new] =
        places_.try_emplace({path.lexically_normal().string(), scale}, next);
    return {found->second, is_new};
  }

 private:
  std::map<std::pair<std::string, double>, uint32_t> places_;
};

}  // namespace seam
