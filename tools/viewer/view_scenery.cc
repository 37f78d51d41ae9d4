#include "tools/viewer/view_scenery.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace seam::tools {
namespace {

using nlohmann::json;

bool moves(Label label) {
  return label == Label::ball || label == Label::robot_red || label == Label::robot_blue ||
         label == Label::robot_body;
}

const char* shape_name(Shape shape) {
  switch (shape) {
    case Shape::rectangle:
      return "rectangle";
    case Shape::box:
      return "box";
    case Shape::sphere:
      return "sphere";
    default:
      return "cylinder";
  }
}

const char* label_name(Label label) {
  constexpr const char* kNames[] = {
      "background",    "carpet",         "line",         "wall",
      "ball",          "goal_yellow",    "goal_skyblue", "beacon_pink",
      "beacon_yellow", "beacon_skyblue", "beacon_green", "beacon_white",
      "robot_red",     "robot_blue",     "robot_body",   "other"};
  return kNames[static_cast<size_t>(label)];
}

int display(double radiance) {
  return static_cast<int>(std::lround(255 * std::pow(std::clamp(radiance, 0.0, 1.0), 1 / 2.2)));
}

}  // namespace

json scenery_of(const World& world) {
  std::vector<Primitive> primitives;
  world.primitives_at(world.start(), primitives);
  std::erase_if(primitives, [](const Primitive& primitive) { return moves(primitive.label); });
  std::stable_sort(primitives.begin(), primitives.end(),
                   [](const auto& a, const auto& b) { return a.X_WO.p.z < b.X_WO.p.z; });
  json scenery = json::array();
  for (const Primitive& primitive : primitives) {
    const Mat3& R = primitive.X_WO.R;
    scenery.push_back(
        {{"shape", shape_name(primitive.shape)},
         {"label", label_name(primitive.label)},
         {"x_m", primitive.X_WO.p.x},
         {"y_m", primitive.X_WO.p.y},
         {"z_m", primitive.X_WO.p.z},
         {"yaw_rad", std::atan2(R[0].y, R[0].x)},
         {"size_m", {primitive.size.x, primitive.size.y, primitive.size.z}},
         {"rgb",
          {display(primitive.rgb[0]), display(primitive.rgb[1]), display(primitive.rgb[2])}}});
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
