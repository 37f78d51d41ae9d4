#include "sim_core/scenario/object_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim_core/scene/drawn_files.h"

namespace seam {
namespace {

constexpr Range kTurn{-7, 7};
constexpr Range kLengths{1e-6, 1e6};

// Turns the z axis to the normal, keeping the x axis horizontal.
Mat3 facing(const Vec3& normal) {
  const Vec3 z = glm::normalize(normal);
  if (std::abs(z.z) > 1 - 1e-12) return z.z > 0 ? Mat3(1.0) : Mat3(1, 0, 0, 0, -1, 0, 0, 0, -1);
  const Vec3 x = glm::normalize(glm::cross(Vec3(0, 0, 1), z));
  return Mat3(x, glm::cross(z, x), z);
}

// Which keys an object of this kind has; all of them for a schema.
class Keys {
 public:
  Keys(const ConfigTable& table, ObjectKind kind) : all_(table.names_alternatives()), kind_(kind) {}
  bool of(std::initializer_list<ObjectKind> kinds) const {
    return all_ || std::find(kinds.begin(), kinds.end(), kind_) != kinds.end();
  }
  bool always() const { return !all_; }

 private:
  bool all_;
  ObjectKind kind_;
};

void describe_place(ConfigTable& table, const Keys& keys, ObjectSpec& object) {
  using enum ObjectKind;
  if (keys.of({rectangle, sphere, box})) {
    table.vec3({"centre_m", "Of a rectangle, sphere or box: its centre, m.", keys.always()},
               object.centre_m);
  }
  if (keys.of({cylinder, capsule}))
    table.vec3({"base_m", "Of a cylinder or capsule: the middle of its base, m.", keys.always()},
               object.centre_m);
  if (keys.of({mesh, board})) {
    table.object({"pose", "Of a mesh or board: where its origin is and how it is turned."},
                 [&](ConfigTable& pose) { describe(pose, object.pose); });
  }
}

void describe_size(ConfigTable& table, const Keys& keys, ObjectSpec& object) {
  using enum ObjectKind;
  if (keys.of({rectangle, box})) {
    table.sizes(
        {"size_m", "Of a rectangle its two sides, of a box its three edges, m.", keys.always()},
        object.size_m, object.kind == rectangle ? 2 : 3);
  }
  if (keys.of({sphere, cylinder, capsule})) {
    table.number({"radius_m", "Of a sphere, cylinder or capsule, m.", keys.always()},
                 object.size_m.x, kLengths);
  }
  if (keys.of({cylinder, capsule}))
    table.number({"height_m", "Of a cylinder or capsule, m.", keys.always()}, object.size_m.z,
                 kLengths);
  if (keys.of({rectangle}))
    table.vec3({"normal", "Of a rectangle; (0, 0, 1) where not given."}, object.normal);
  if (keys.of({box}))
    table.number({"yaw_rad", "Of a box: turn about z, rad."}, object.yaw_rad, kTurn);
  if (keys.of({mesh})) describe_mesh_file(table, keys.always(), object.mesh, object.scale);
}

}  // namespace

void describe(ConfigTable& table, ObjectSpec& object) {
  using enum ObjectKind;
  const std::vector<std::string> labels = {
      "background",    "carpet",         "line",         "wall",
      "ball",          "goal_yellow",    "goal_skyblue", "beacon_pink",
      "beacon_yellow", "beacon_skyblue", "beacon_green", "beacon_white",
      "robot_red",     "robot_blue",     "robot_body",   "other"};
  table.choice_of({"shape", "Its shape.", true}, object.kind,
                  {"rectangle", "sphere", "cylinder", "capsule", "box", "mesh", "board"});
  const Keys keys(table, object.kind);
  describe_place(table, keys, object);
  describe_size(table, keys, object);
  table.vec3(
      {"velocity_mps", "It is at the stated place at time 0 and moves at this velocity, m/s."},
      object.velocity_mps);
  if (keys.of({rectangle, box})) describe_texture(table, object.texture);
  if (keys.of({board})) describe(table, object.board);
  if (keys.of({rectangle, sphere, cylinder, capsule, box, mesh})) {
    const bool coloured = keys.of({mesh}) || !object.texture.name.empty();
    table.numbers({"rgb",
                   "Linear radiance, 0 to 1; of a mesh or texture a factor on its own colours, 1 "
                   "where not given.",
                   keys.always() && !coloured},
                  object.rgb);
  }
  table.choice_of({"label", "Ground-truth class."}, object.label, labels);
  table.require(glm::length(object.normal) > 0, "normal", "expected a direction, found no length");
}

std::vector<Primitive> primitives_of(const ObjectSpec& object, uint16_t object_id) {
  if (object.kind == ObjectKind::board || object.kind == ObjectKind::mesh) {
    const Pose X_WO = object.pose.pose();
    if (object.kind == ObjectKind::board) {
      std::vector<Primitive> parts = board_primitives(object.board, X_WO, object_id);
      for (Primitive& part : parts) part.label = object.label;
      return parts;
    }
    return {{.shape = Shape::mesh,
             .label = object.label,
             .object_id = object_id,
             .X_WO = X_WO,
             .size = object.size_m,
             .rgb = object.rgb,
             .asset = object.asset}};
  }
  const Mat3 R = object.kind == ObjectKind::rectangle ? facing(object.normal) : Mat3(1.0);
  return {{.shape = static_cast<Shape>(object.kind),
           .label = object.label,
           .object_id = object_id,
           .X_WO = {rotation_zyx(0, 0, object.yaw_rad) * R, object.centre_m},
           .size = object.size_m,
           .rgb = object.rgb,
           .asset = object.asset}};
}

}  // namespace seam
