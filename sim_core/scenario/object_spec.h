// An object of a scenario beside field, ball and robots.
#pragma once

#include <string>
#include <vector>

#include "sim_core/input/config_table.h"
#include "sim_core/scene/board.h"
#include "sim_core/scene/placement.h"
#include "sim_core/scene/scene.h"

namespace seam {

// What a scenario's file says of an object, with the keys of seam-scene/1 and beyond.
enum class ObjectKind : uint8_t { rectangle, sphere, cylinder, capsule, box, mesh, board };

struct ObjectSpec {
  ObjectKind kind = ObjectKind::box;
  Vec3 centre_m{0.0};  // Of a cylinder the middle of its base.
  Vec3 velocity_mps{0.0};
  Vec3 size_m{0.1};      // As Primitive::size.
  Vec3 normal{0, 0, 1};  // Of a rectangle.
  double yaw_rad = 0;    // Of a box.
  Placement pose;        // Of a mesh or board.
  Rgb rgb{1, 1, 1};
  Label label = Label::other;
  FileName mesh;
  double scale = 1;  // Of a mesh.
  FileName texture;  // Of a rectangle or box.
  BoardSpec board;
  uint32_t asset = 0;  // As Primitive::asset; whoever reads meshes and textures sets it.

  // What the ray caster cannot draw.
  bool needs_opengl() const { return !mesh.name.empty() || !texture.name.empty(); }
};

void describe(ConfigTable& table, ObjectSpec& object);

// At time 0; all parts move with the object's velocity.
std::vector<Primitive> primitives_of(const ObjectSpec& object, uint16_t object_id);

}  // namespace seam
