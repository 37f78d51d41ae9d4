// Scenes of measurement sets: a YAML file of format `seam-scene/1` (docs/reference/measurements.md)
// as a function of continuous time.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "sim_core/base/config.h"
#include "sim_core/input/config_table.h"
#include "sim_core/scene/scene.h"

namespace seam {

// The meshes and textures that a scene's objects name, each in the order of Primitive::asset.
struct SceneFiles {
  struct MeshFile {
    FileName file;
    double scale = 1;  // Metres for a unit of the file.
  };
  std::vector<MeshFile> meshes;
  std::vector<FileName> textures;

  // Then the ray caster can draw the scene.
  bool empty() const { return meshes.empty() && textures.empty(); }
};

class FileScene : public SceneSource {
 public:
  // A mesh's primitive has the size 0 until whoever reads the files says its radius.
  virtual const SceneFiles& files() const = 0;
};

// Time 0 of the scene (where objects with a velocity are at their stated place) is SimTime zero.
// Throws InputError naming file, line and key.
std::unique_ptr<FileScene> read_scene(const std::filesystem::path& path);
std::unique_ptr<FileScene> read_scene(const ConfigNode& root);
// JSON Schema of the format (docs/reference/schemas/scene.schema.json), from the reader's table.
std::string scene_schema();

}  // namespace seam
