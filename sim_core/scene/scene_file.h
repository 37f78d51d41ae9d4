// Scenes of measurement sets: a YAML file of format `seam-scene/1` (docs/measurements.md) as a
// function of continuous time.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "sim_core/base/config.h"
#include "sim_core/scene/scene.h"

namespace seam {

// Time 0 of the scene (where objects with a velocity are at their stated place) is SimTime zero.
// Throws InputError naming file, line and key.
std::unique_ptr<SceneSource> read_scene(const std::filesystem::path& path);
std::unique_ptr<SceneSource> read_scene(const ConfigNode& root);
// JSON Schema of the format (docs/schemas/scene.schema.json), from the table that the reader uses.
std::string scene_schema();

}  // namespace seam
