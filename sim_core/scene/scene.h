// What a camera can see: solid primitives with linear radiance, and their state at an instant.
// The same description serves matches, experiments and the `scene:` files of measurement sets.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "sim_core/base/pose.h"
#include "sim_core/base/time.h"

namespace seam {

enum class Shape : uint8_t {
  rectangle,  // In the object's xy-plane, centred; size.x by size.y; seen from both sides.
  sphere,     // Centred; radius size.x.
  cylinder,   // Closed, along z from 0 to size.z (height); radius size.x.
  capsule,    // A cylinder along z from 0 to size.z with hemispheres beyond; radius size.x.
  box,        // Centred; full edge lengths size.
  mesh,       // Triangles of a file (OpenGL alone draws it); no point is farther than size.x.
};

using Rgb = std::array<double, 3>;  // Linear radiance, 0 to 1 is the camera's nominal range.

// Ground-truth classes; also the index of the colour class where an object has one.
enum class Label : uint8_t {
  background,
  carpet,
  line,
  wall,
  ball,
  goal_yellow,
  goal_skyblue,
  beacon_pink,
  beacon_yellow,
  beacon_skyblue,
  beacon_green,
  beacon_white,
  robot_red,
  robot_blue,
  robot_body,
  other,
};

struct Primitive {
  Shape shape = Shape::sphere;
  Label label = Label::other;
  uint16_t object_id = 0;  // The same for all parts of one object (a robot); for ground truth.
  Pose X_WO;               // The object's frame in the world at the instant.
  Vec3 size{0.0};          // Metres; meaning by shape, see above.
  Rgb rgb{0, 0, 0};
  // Of a mesh, which; of a rectangle or box, its texture: from 1 on in the order in which the
  // scenario's objects name them, 0 for none. `rgb` is a factor on their colours.
  uint32_t asset = 0;
};

// Lambertian shading: rgb * (ambient + diffuse * max(0, n . direction)). Flat when `lambert` is
// false: an object's own rgb.
struct Lighting {
  bool lambert = false;
  Vec3 direction_W{0, 0, 1};  // Unit vector towards the light.
  double ambient = 1;
  double diffuse = 0;
};

// Where a figure is and how it holds its joints: all its parts' places follow from it.
struct Posture {
  Vec3 turn_rad{0.0};  // R_WB = Rz(z) Ry(y) Rx(x).
  Vec3 p_WB{0.0};
  std::array<double, 64> joints_rad{};  // As JointAngles.
};

// What moves by its joints: a robot. A frame samples its light at many instants, at most of which
// few robots are in view; so instants hold postures, and parts are placed where they may be seen.
class Figure {
 public:
  virtual ~Figure() = default;
  // How many `add_parts` appends, always the same shapes in the same order.
  virtual size_t part_count() const = 0;
  virtual void add_parts(const Posture& posture, std::vector<Primitive>& out) const = 0;
  // No point of the balls about its parts (bounding_ball.h) is ever farther from p_WB.
  virtual double radius_m() const = 0;
  // What people call one of them.
  virtual std::string part_name(size_t) const { return "a figure"; }
  // No point of these balls is farther from where it is in the other posture.
  virtual double motion_bound_m(const Posture& a, const Posture& b) const = 0;
};

struct FigureAt {
  const Figure* figure;
  Posture posture;
};

// Everything that light-sampling needs at one instant.
struct SceneInstant {
  SimTime time;
  Pose X_WC;  // Camera frame C (x right, y down, z forward) in the world.
  std::vector<Primitive> primitives;
  std::vector<FigureAt> figures;  // Their parts follow the primitives, in this order.
};

// A scene as a function of continuous time.
class SceneSource {
 public:
  virtual ~SceneSource() = default;
  virtual Rgb background() const = 0;
  virtual Lighting lighting() const = 0;
  // The primitives at this instant, appended to `out` in an order that never depends on anything
  // but the scene.
  virtual void primitives_at(SimTime time, std::vector<Primitive>& out) const = 0;
};

}  // namespace seam
