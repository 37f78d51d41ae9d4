#include "sim_core/scene/scene_file.h"

#include <glm/geometric.hpp>

#include "sim_core/base/error.h"

namespace seam {
namespace {

struct MovingPrimitive {
  Primitive at_zero;
  Vec3 velocity_mps{0.0};
};

class FileScene final : public SceneSource {
 public:
  Rgb background() const override { return background_; }
  Lighting lighting() const override { return lighting_; }
  void primitives_at(SimTime time, std::vector<Primitive>& out) const override {
    for (const MovingPrimitive& object : objects_) {
      out.push_back(object.at_zero);
      out.back().X_WO.p += object.velocity_mps * time.s();
    }
  }

  Rgb background_{0, 0, 0};
  Lighting lighting_;
  std::vector<MovingPrimitive> objects_;
};

Rgb read_rgb(const ConfigNode& node) {
  const auto values = node.numbers(3);
  for (const double value : values) {
    if (value < 0 || value > 1e6)
      node.fail(fmt::format("found {}, expected linear radiance of 0 or more", value));
  }
  return {values[0], values[1], values[2]};
}

double length(const ConfigNode& node) {
  const double value = node.number({0, 1e6});
  if (value <= 0) node.fail(fmt::format("found {}, expected more than 0 metres", value));
  return value;
}

// The frame of a rectangle: z along the normal, x horizontal (along world x for an upright normal).
Mat3 rectangle_axes(const ConfigNode& node, Vec3 normal) {
  const double size = glm::length(normal);
  if (!(size > 1e-12)) node.fail("found a zero vector, expected a direction");
  normal /= size;
  const Vec3 up{0, 0, 1};
  Vec3 x = glm::cross(up, normal);
  // A level rectangle has its first side along world x.
  x = glm::length(x) < 1e-9 ? Vec3{1, 0, 0} : glm::normalize(x);
  return Mat3(x, glm::cross(normal, x), normal);
}

MovingPrimitive read_object(const ConfigNode& node, uint16_t id) {
  MovingPrimitive object;
  Primitive& primitive = object.at_zero;
  primitive.object_id = id;
  switch (node.at("shape").choice({"rectangle", "sphere", "cylinder", "box"})) {
    case 0: {
      primitive.shape = Shape::rectangle;
      const ConfigNode size = node.at("size_m");
      const auto sides = size.numbers(2);
      if (!(sides[0] > 0 && sides[1] > 0)) size.fail("expected two lengths of more than 0 metres");
      primitive.size = {sides[0], sides[1], 0};
      const auto normal = node.find("normal");
      const Vec3 direction = normal ? normal->vec3() : Vec3{0, 0, 1};
      primitive.X_WO = {rectangle_axes(normal ? *normal : node, direction),
                        node.at("centre_m").vec3()};
      break;
    }
    case 1:
      primitive.shape = Shape::sphere;
      primitive.size = Vec3(length(node.at("radius_m")));
      primitive.X_WO.p = node.at("centre_m").vec3();
      break;
    case 2: {
      primitive.shape = Shape::cylinder;
      const double radius = length(node.at("radius_m"));
      primitive.size = {radius, radius, length(node.at("height_m"))};
      primitive.X_WO.p = node.at("base_m").vec3();
      break;
    }
    default: {
      primitive.shape = Shape::box;
      const ConfigNode size = node.at("size_m");
      primitive.size = size.vec3();
      if (!(primitive.size.x > 0 && primitive.size.y > 0 && primitive.size.z > 0)) {
        size.fail("expected three lengths of more than 0 metres");
      }
      primitive.X_WO = {rotation_about({0, 0, 1}, node.number_or("yaw_rad", 0, {-1e3, 1e3})),
                        node.at("centre_m").vec3()};
    }
  }
  primitive.rgb = read_rgb(node.at("rgb"));
  if (const auto velocity = node.find("velocity_mps")) object.velocity_mps = velocity->vec3();
  node.finish();
  return object;
}

}  // namespace

std::unique_ptr<SceneSource> read_scene(const ConfigNode& root) {
  auto scene = std::make_unique<FileScene>();
  root.at("format").choice({"seam-scene/1"});
  scene->background_ = read_rgb(root.at("background_rgb"));
  const auto shading = root.find("shading");
  scene->lighting_.lambert = shading && shading->choice({"flat", "lambert"}) == 1;
  if (const auto light = root.find("light")) {
    const ConfigNode direction = light->at("direction");
    const Vec3 towards = direction.vec3();
    if (!(glm::length(towards) > 1e-12))
      direction.fail("found a zero vector, expected a direction");
    scene->lighting_.direction_W = glm::normalize(towards);
    scene->lighting_.ambient = light->number_or("ambient", 0.4, {0, 1e3});
    scene->lighting_.diffuse = light->number_or("diffuse", 0.6, {0, 1e3});
    light->finish();
  } else if (scene->lighting_.lambert) {
    root.fail("light: is missing: shading 'lambert' needs its direction");
  }
  const auto objects = root.find("objects");
  if (objects) {
    uint16_t id = 1;
    for (const ConfigNode& node : objects->items())
      scene->objects_.push_back(read_object(node, id++));
  }
  root.finish();
  return scene;
}

std::unique_ptr<SceneSource> read_scene(const std::filesystem::path& path) {
  return read_scene(ConfigNode::from_file(path));
}

}  // namespace seam
