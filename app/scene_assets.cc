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
  render::Assets take() { return std::move(assets_); }

 private:
  using Key = std::tuple<std::string, std::string, double>;

  void add_mesh(ObjectSpec& object) {
    uint32_t& place = meshes_[{object.mesh.folder, object.mesh.name, object.scale}];
    if (place == 0) {
      assets_.meshes.push_back(render::read_mesh(object.mesh, object.scale));
      place = static_cast<uint32_t>(assets_.meshes.size());
    }
    object.asset = place;
    object.size_m = Vec3(assets_.meshes[place - 1].radius_m);
    object.mesh.fingerprint = assets_.meshes[place - 1].fingerprint;
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

}  // namespace

std::unique_ptr<render::GlDevice> device_for(Scenario& scenario, const std::string& drawing) {
  const ObjectSpec* needy = nullptr;
  for (const ObjectSpec& object : scenario.objects)
    if (object.needs_opengl() && !needy) needy = &object;
  if (needy && drawing == "analytic") {
    throw InputError(fmt::format(
        "{}: object with the file '{}': the ray caster has neither meshes nor textures, expected "
        "--renderer opengl or auto",
        scenario.name, needy->mesh.name.empty() ? needy->texture.name : needy->mesh.name));
  }
  if (!needy && drawing != "opengl") return nullptr;
  SceneAssets assets;
  for (ObjectSpec& object : scenario.objects) assets.add(object);
  return std::make_unique<render::GlDevice>(assets.take());
}

}  // namespace seam::app
