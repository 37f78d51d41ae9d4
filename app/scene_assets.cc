#include "app/scene_assets.h"

#include "app/asset_reader.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

void read_for(ObjectSpec& object, AssetReader& reader) {
  if (!object.mesh.name.empty()) {
    object.asset = reader.mesh(object.mesh, object.scale);
    object.size_m = Vec3(reader.radius_m(object.asset));
  }
  if (!object.texture.name.empty()) object.asset = reader.texture(object.texture);
}

void read_for(BodyPart& part, AssetReader& reader) {
  if (part.mesh.name.empty()) return;
  part.asset = reader.mesh(part.mesh, part.scale);
  part.size_m = Vec3(reader.radius_m(part.asset));
}

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

render::Assets read_assets(Scenario& scenario) {
  AssetReader reader;
  for (ObjectSpec& object : scenario.objects) read_for(object, reader);
  for (RobotSpec& robot : scenario.robots)
    for (BodyPart& part : robot.body.parts) read_for(part, reader);
  return reader.take();
}

render::Assets read_assets(const SceneFiles& files) {
  // Each is there once: places are those of the scene.
  AssetReader reader;
  for (SceneFiles::MeshFile mesh : files.meshes) reader.mesh(mesh.file, mesh.scale);
  for (FileName texture : files.textures) reader.texture(texture);
  return reader.take();
}

render::Assets read_assets(RobotBody& body) {
  AssetReader reader;
  for (BodyPart& part : body.parts) read_for(part, reader);
  return reader.take();
}

std::unique_ptr<render::GlDevice> device_for(Scenario& scenario, const std::string& drawing,
                                             const std::string& gl) {
  const std::string needy = file_for_opengl(scenario);
  if (!needy.empty() && drawing == "analytic") {
    throw InputError(fmt::format(
        "{}: object with the file '{}': the ray caster has neither meshes nor textures, expected "
        "--renderer opengl or auto",
        scenario.name, needy));
  }
  if (needy.empty() && drawing != "opengl") return nullptr;
  return std::make_unique<render::GlDevice>(read_assets(scenario), gl);
}

}  // namespace seam::app
