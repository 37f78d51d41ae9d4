#include "app/scene_assets.h"

#include <map>
#include <tuple>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

// Reads each file once.
class SceneAssets {
 public:
  void add(ObjectSpec& object) {
    if (!object.mesh.name.empty()) add_mesh(object);
    if (!object.texture.name.empty()) add_texture(object);
  }
  void add(BodyPart& part) {
    if (part.mesh.name.empty()) return;
    part.asset = mesh_place(part.mesh, part.scale);
    part.size_m = Vec3(assets_.meshes[part.asset - 1].radius_m);
  }
  render::Assets take() { return std::move(assets_); }

 private:
  using Key = std::tuple<std::string, std::string, double>;

  // Reads what was not read yet, and leaves its fingerprint with its name.
  uint32_t mesh_place(FileName& file, double scale) {
    uint32_t& place = meshes_[{file.folder, file.name, scale}];
    if (place == 0) {
      assets_.meshes.push_back(render::read_mesh(file, scale));
      place = static_cast<uint32_t>(assets_.meshes.size());
    }
    file.fingerprint = assets_.meshes[place - 1].fingerprint;
    return place;
  }
  void add_mesh(ObjectSpec& object) {
    object.asset = mesh_place(object.mesh, object.scale);
    object.size_m = Vec3(assets_.meshes[object.asset - 1].radius_m);
  }
  void add_texture(ObjectSpec& object) {
    uint32_t& place = textures_[{object.texture.folder, object.texture.name, 1}];
    if (place == 0) {
      assets_.textures.push_back(render::read_texture(object.texture));
      place = static_cast<uint32_t>(assets_.textures.size());
    }
    object.asset = place;
    object.texture.fingerprint = assets_.textures[place - 1].fingerprint;
  }

  render::Assets assets_;
  std::map<Key, uint32_t> meshes_, textures_;
};

// The first mesh or texture; empty where there is none.
std::string file_for_opengl(const Scenario& scenario) {
  for (const ObjectSpec& object : scenario.objects)
    if (object.needs_opengl())
      return object.mesh.name.empty() ? object.texture.name : object.mesh.name;
  for (const RobotSpec& robot : scenario.robots)
    for (const BodyPart& part : robot.body.parts)
      if (!part.mesh.name.empty()) return part.mesh.name;
  return "";
}

}  // namespace

std::unique_ptr<render::GlDevice> device_for(Scenario& scenario, const std::string& drawing) {
  const std::string needy = file_for_opengl(scenario);
  if (!needy.empty() && drawing == "analytic") {
    throw InputError(fmt::format(
        "{}: object with the file '{}': the ray caster has neither meshes nor textures, expected "
        "--renderer opengl or auto",
        scenario.name, needy));
  }
  if (needy.empty() && drawing != "opengl") return nullptr;
  SceneAssets assets;
  for (ObjectSpec& object : scenario.objects) assets.add(object);
  for (RobotSpec& robot : scenario.robots)
    for (BodyPart& part : robot.body.parts) assets.add(part);
  return std::make_unique<render::GlDevice>(assets.take());
}

}  // namespace seam::app
