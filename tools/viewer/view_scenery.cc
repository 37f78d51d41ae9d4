#include "tools/viewer/view_scenery.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/viewer/footprint.h"

namespace seam::tools {
namespace {

using nlohmann::json;

bool moves(Label label) {
  return label == Label::ball || label == Label::robot_red || label == Label::robot_blue ||
         label == Label::robot_body;
}

const char* label_name(Label label) {
  constexpr const char* kNames[] = {
      "background",    "carpet",         "line",         "wall",
      "ball",          "goal_yellow",    "goal_skyblue", "beacon_pink",
      "beacon_yellow", "beacon_skyblue", "beacon_green", "beacon_white",
      "robot_red",     "robot_blue",     "robot_body",   "other"};
  return kNames[static_cast<size_t>(label)];
}

constexpr double kGamma = 2.2;

int display(double radiance) {
  return static_cast<int>(std::lround(255 * std::pow(std::clamp(radiance, 0.0, 1.0), 1 / kGamma)));
}

// Of a picture in sRGB, as if it were one radiance.
Rgb mean_of(const render::Picture& picture) {
  std::array<double, 3> sum{};
  for (size_t i = 0; i < picture.rgb.size(); ++i) sum[i % 3] += picture.rgb[i];
  for (double& value : sum)
    value = std::pow(3 * value / (255.0 * static_cast<double>(picture.rgb.size())), kGamma);
  return sum;
}

Rgb mean_of(const render::Mesh& mesh) {
  Rgb mean{};
  for (const render::MeshVertex& vertex : mesh.vertices)
    for (size_t i = 0; i < 3; ++i)
      mean[i] += vertex.rgb[i] / static_cast<double>(mesh.vertices.size());
  return mean;
}

// The one colour that a thing has from afar.
Rgb colour_of(const Primitive& primitive, const render::Assets* assets) {
  Rgb colour = primitive.rgb;
  if (assets == nullptr || primitive.asset == 0) return colour;
  const size_t asset = primitive.asset - 1;
  std::vector<Rgb> factors;
  if (primitive.shape != Shape::mesh) {
    factors.push_back(mean_of(*assets->textures.at(asset).picture));
  } else {
    const render::Mesh& mesh = assets->meshes.at(asset);
    factors.push_back(mean_of(mesh));
    if (!mesh.pictures.empty()) factors.push_back(mean_of(*mesh.pictures.front()));
  }
  for (const Rgb& factor : factors)
    for (size_t i = 0; i < 3; ++i) colour[i] *= factor[i];
  return colour;
}

}  // namespace

json scenery_of(const World& world, const render::Assets* assets) {
  std::vector<Primitive> primitives;
  world.primitives_at(world.start(), primitives);
  struct Item {
    Footprint footprint;
    Primitive primitive;
  };
  std::vector<Item> items;
  for (const Primitive& primitive : primitives)
    if (!moves(primitive.label)) items.push_back({footprint_of(primitive, assets), primitive});
  std::ranges::stable_sort(items, {}, [](const Item& item) { return item.footprint.top_m; });
  json scenery = json::array();
  for (const auto& [footprint, primitive] : items) {
    const Rgb rgb = colour_of(primitive, assets);
    scenery.push_back({{"label", label_name(primitive.label)},
                       {"top_m", footprint.top_m},
                       {"footprint_m", footprint.corners},
                       {"rgb", {display(rgb[0]), display(rgb[1]), display(rgb[2])}}});
  }
  return scenery;
}

json robots_of(const Scenario& scenario) {
  json robots = json::array();
  for (size_t i = 0; i < scenario.robots.size(); ++i) {
    const RobotSpec& robot = scenario.robots[i];
    robots.push_back(
        {{"id", robot.id},
         {"team", robot.team == Team::red ? "red" : "blue"},
         {"number", i},
         {"camera", {{"width_px", robot.camera.width_px}, {"height_px", robot.camera.height_px}}}});
  }
  return robots;
}

}  // namespace seam::tools
