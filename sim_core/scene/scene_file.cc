#include "sim_core/scene/scene_file.h"

#include <glm/geometric.hpp>

#include "sim_core/base/error.h"
#include "sim_core/input/config_table.h"
#include "sim_core/input/shown_text.h"
#include "sim_core/scene/board.h"
#include "sim_core/scene/drawn_files.h"
#include "sim_core/scene/placement.h"

namespace seam {
namespace {

struct MovingPrimitive {
  Primitive at_zero;
  Vec3 velocity_mps{0.0};
};

class ReadScene final : public FileScene {
 public:
  Rgb background() const override { return background_; }
  Lighting lighting() const override { return lighting_; }
  void primitives_at(SimTime time, std::vector<Primitive>& out) const override {
    for (const MovingPrimitive& object : objects_) {
      out.push_back(object.at_zero);
      out.back().X_WO.p += object.velocity_mps * time.s();
    }
  }

  const SceneFiles& files() const override { return files_; }

  Rgb background_{0, 0, 0};
  Lighting lighting_;
  std::vector<MovingPrimitive> objects_;
  SceneFiles files_;
};

// The frame of a rectangle: z along the normal, x horizontal (along world x for an upright normal).
Mat3 rectangle_axes(Vec3 normal) {
  normal /= glm::length(normal);
  const Vec3 up{0, 0, 1};
  Vec3 x = glm::cross(up, normal);
  // A level rectangle has its first side along world x.
  x = glm::length(x) < 1e-9 ? Vec3{1, 0, 0} : glm::normalize(x);
  return Mat3(x, glm::cross(normal, x), normal);
}

// An object as the file states it; what its shape lacks stays as it is here.
struct SceneObject {
  size_t shape = 0;  // Into kShapes.
  Vec3 place_m{0.0};
  Vec3 size_m{1.0};
  double radius_m = 1, height_m = 1;
  Vec3 normal{0, 0, 1};
  double yaw_rad = 0;
  Rgb rgb{0, 0, 0};
  Vec3 velocity_mps{0.0};
  Placement pose;  // Of a board or mesh.
  BoardSpec board;
  SceneFiles::MeshFile mesh;
  FileName texture;
};

const std::vector<std::string> kShapes = {"rectangle", "sphere", "cylinder", "box",
                                          "capsule",   "board",  "mesh"};
enum : size_t { kRectangle, kSphere, kCylinder, kBox, kCapsule, kBoard, kMesh };
constexpr size_t kMaxObjects = 65535;
constexpr size_t kMaxParts = 200'000;  // Of all objects: boards have many.

void describe_rgb(ConfigTable& table, ConfigKey key, Rgb& rgb) {
  table.numbers(key, rgb);
  for (const double value : rgb) {
    table.require(value >= 0 && value <= 1e6, key.key,
                  fmt::format("found {}, expected linear radiance of 0 or more", value));
  }
}

void describe_direction(ConfigTable& table, ConfigKey key, Vec3& direction) {
  table.vec3(key, direction);
  table.require(glm::length(direction) > 1e-12, key.key,
                "found a zero vector, expected a direction");
}

void describe_length(ConfigTable& table, ConfigKey key, double& length_m) {
  table.number(key, length_m, {0, 1e6});
  table.require(length_m > 0, key.key,
                fmt::format("found {}, expected more than 0 metres", length_m));
}

void describe_object(ConfigTable& table, SceneObject& object) {
  table.choice({"shape", "Its shape.", true}, object.shape, kShapes);
  const bool all = table.names_alternatives(), always = !all;
  const auto is = [&](size_t shape) { return all || object.shape == shape; };
  if (is(kRectangle) || is(kSphere) || is(kBox))
    table.vec3({"centre_m", "Of a rectangle, sphere or box: its centre at time 0, m.", always},
               object.place_m);
  if (is(kCylinder) || is(kCapsule))
    table.vec3({"base_m", "Of a cylinder or capsule: the middle of its base at time 0, m.", always},
               object.place_m);
  if (is(kBoard) || is(kMesh))
    table.object(
        {"pose",
         "Of a board or mesh: where its middle or origin is at time 0 and how it is turned."},
        [&](ConfigTable& pose) { describe(pose, object.pose); });
  if (is(kRectangle) || is(kBox))
    table.sizes({"size_m", "Of a rectangle its two sides, of a box its three edges, m.", always},
                object.size_m, object.shape == kRectangle ? 2 : 3);
  if (is(kSphere) || is(kCylinder) || is(kCapsule))
    describe_length(table, {"radius_m", "Of a sphere, cylinder or capsule, m.", always},
                    object.radius_m);
  if (is(kCylinder) || is(kCapsule))
    describe_length(table, {"height_m", "Of a cylinder or capsule, m.", always}, object.height_m);
  if (is(kRectangle))
    describe_direction(table, {"normal", "Of a rectangle; (0, 0, 1) where not given."},
                       object.normal);
  if (is(kBox))
    table.number({"yaw_rad", "Of a box: turn about z, rad."}, object.yaw_rad, {-1e3, 1e3});
  if (is(kBoard)) describe(table, object.board);
  if (is(kMesh)) describe_mesh_file(table, always, object.mesh.file, object.mesh.scale);
  if (is(kRectangle) || is(kBox)) describe_texture(table, object.texture);
  if (all || object.shape != kBoard) {
    const bool coloured = object.shape == kMesh || !object.texture.name.empty();
    if (coloured) object.rgb = {1, 1, 1};
    describe_rgb(table,
                 {"rgb",
                  "Linear radiance, red, green, blue; of a mesh or texture a factor on its own "
                  "colours, 1 where not given.",
                  always && !coloured},
                 object.rgb);
  }
  table.vec3({"velocity_mps", "How it moves from its place at time 0, m/s."}, object.velocity_mps);
}

// Where the files that objects name stand among the scene's.
class PlacesOfFiles {
 public:
  explicit PlacesOfFiles(SceneFiles& files) : files_(files) {}

  uint32_t of(const SceneObject& object) {
    if (object.shape == kMesh) {
      const auto [place, is_new] = meshes_.of(object.mesh.file, object.mesh.scale);
      if (is_new) files_.meshes.push_back(object.mesh);
      return place;
    }
    if (object.texture.name.empty()) return 0;
    const auto [place, is_new] = textures_.of(object.texture);
    if (is_new) files_.textures.push_back(object.texture);
    return place;
  }

 private:
  SceneFiles& files_;
  FilePlaces meshes_, textures_;
};

std::vector<Primitive> primitives_of(const SceneObject& object, uint16_t id,
                                     PlacesOfFiles& places) {
  if (object.shape == kBoard) return board_primitives(object.board, object.pose.pose(), id);
  Primitive primitive;
  primitive.asset = places.of(object);
  primitive.object_id = id;
  primitive.rgb = object.rgb;
  primitive.X_WO.p = object.place_m;
  switch (object.shape) {
    case kRectangle:
      primitive.shape = Shape::rectangle;
      primitive.size = {object.size_m.x, object.size_m.y, 0};
      primitive.X_WO.R = rectangle_axes(object.normal);
      break;
    case kSphere:
      primitive.shape = Shape::sphere;
      primitive.size = Vec3(object.radius_m);
      break;
    case kCylinder:
    case kCapsule:
      primitive.shape = object.shape == kCylinder ? Shape::cylinder : Shape::capsule;
      primitive.size = {object.radius_m, object.radius_m, object.height_m};
      break;
    case kMesh:
      primitive.shape = Shape::mesh;
      primitive.X_WO = object.pose.pose();
      break;
    default:
      primitive.shape = Shape::box;
      primitive.size = object.size_m;
      primitive.X_WO.R = rotation_about({0, 0, 1}, object.yaw_rad);
  }
  return {primitive};
}

// A scene file as it stands.
struct SceneFile {
  Rgb background{0, 0, 0};
  bool has_light = false;
  Lighting lighting;
  std::vector<SceneObject> objects;
};

void describe_light(ConfigTable& table, Lighting& lighting) {
  lighting.ambient = 0.4, lighting.diffuse = 0.6;
  describe_direction(table, {"direction", "Towards the light; any length.", true},
                     lighting.direction_W);
  table.number({"ambient", "Light from all sides."}, lighting.ambient, {0, 1e3});
  table.number({"diffuse", "Light from that direction."}, lighting.diffuse, {0, 1e3});
}

void describe_scene(ConfigTable& table, SceneFile& scene) {
  table.format("seam-scene/1");
  describe_rgb(table, {"background_rgb", "What is seen where nothing stands, linear.", true},
               scene.background);
  size_t shading = 0;
  table.choice(
      {"shading", "flat: an object's own rgb; lambert: rgb * (ambient + diffuse * max(0, n.l))."},
      shading, {"flat", "lambert"});
  scene.lighting.lambert = shading == 1;
  table.object({"light", "The light of lambert shading."}, [&](ConfigTable& light) {
    scene.has_light = true;
    describe_light(light, scene.lighting);
  });
  table.require(scene.has_light || !scene.lighting.lambert, "light",
                "light: is missing: shading 'lambert' needs its direction");
  table.list(
      {"objects", "What is to be seen."}, scene.objects.size(), kMaxObjects,
      [&](size_t count) { scene.objects.resize(count); },
      [&](ConfigTable& object, size_t i) { describe_object(object, scene.objects[i]); });
}

// Logs name folders with their files; sets come from anywhere, and what they name stays in theirs.
void check_folders(const ConfigNode& root, const SceneFiles& files) {
  const std::string own =
      std::filesystem::absolute(std::filesystem::path(root.file())).parent_path().string();
  const auto check = [&](const FileName& file) {
    if (file.folder != own)
      root.fail(fmt::format("the file '{}' is looked for in {}, expected one in the scene's folder",
                            shown(file.name), shown(file.folder)));
  };
  for (const SceneFiles::MeshFile& mesh : files.meshes) check(mesh.file);
  for (const FileName& texture : files.textures) check(texture);
}

}  // namespace

std::unique_ptr<FileScene> read_scene(const ConfigNode& root) {
  root.at("format");
  SceneFile file;
  read_config(root, [&](ConfigTable& table) { describe_scene(table, file); });
  auto scene = std::make_unique<ReadScene>();
  scene->background_ = file.background;
  scene->lighting_ = file.lighting;
  if (file.has_light) scene->lighting_.direction_W = glm::normalize(file.lighting.direction_W);
  PlacesOfFiles places(scene->files_);
  for (size_t i = 0; i < file.objects.size(); ++i) {
    for (const Primitive& part :
         primitives_of(file.objects[i], static_cast<uint16_t>(i + 1), places))
      scene->objects_.push_back({part, file.objects[i].velocity_mps});
    if (scene->objects_.size() > kMaxParts)
      root.fail(fmt::format("found boards of more than {} parts in all", kMaxParts));
  }
  check_folders(root, scene->files_);
  return scene;
}

std::string scene_schema() {
  SceneFile scene;
  return config_schema("SEAM scene", [&](ConfigTable& table) { describe_scene(table, scene); });
}

std::unique_ptr<FileScene> read_scene(const std::filesystem::path& path) {
  return read_scene(ConfigNode::from_file(path));
}

}  // namespace seam
