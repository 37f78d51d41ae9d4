#include "app/import/kinds/log_scene.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr double kStraight = 1e-6;  // Of unit vectors.

std::string numbers(const Vec3& v) {
  return fmt::format("[{}, {}, {}]", exact(v.x), exact(v.y), exact(v.z));
}

bool is_level(const Vec3& axis) {
  return std::abs(axis.z) < kStraight;
}

bool is_upright(const Mat3& R) {
  return R[2].z > 1 - kStraight;
}

std::string box(const Vec3& centre, const Vec3& size, double yaw_rad) {
  return fmt::format("shape: box, centre_m: {}, size_m: {}, yaw_rad: {}", numbers(centre),
                     numbers(size), exact(yaw_rad));
}

// A scene's rectangle has its first side level, along x where it lies flat.
std::optional<std::string> rectangle(const Primitive& part) {
  const Mat3& R = part.X_WO.R;
  const auto as = [&](double width, double height) {
    return fmt::format("shape: rectangle, centre_m: {}, size_m: [{}, {}], normal: {}",
                       numbers(part.X_WO.p), exact(width), exact(height), numbers(R[2]));
  };
  if (std::abs(R[2].z) > 1 - kStraight) {
    if (std::abs(R[0].x) > 1 - kStraight) return as(part.size.x, part.size.y);
    if (std::abs(R[0].y) > 1 - kStraight) return as(part.size.y, part.size.x);
    // Turned on the ground: a box without height.
    constexpr double kThin_m = 1e-6;
    return box(part.X_WO.p, {part.size.x, part.size.y, kThin_m}, std::atan2(R[0].y, R[0].x));
  }
  if (is_level(R[0])) return as(part.size.x, part.size.y);
  if (is_level(R[1])) return as(part.size.y, part.size.x);
  return std::nullopt;
}

// As the objects of a scene are written; nothing where none is like it.
std::optional<std::string> shape_of(const Primitive& part) {
  const Pose& X = part.X_WO;
  if (part.asset != 0) return std::nullopt;
  switch (part.shape) {
    case Shape::rectangle:
      return rectangle(part);
    case Shape::sphere:
      return fmt::format("shape: sphere, centre_m: {}, radius_m: {}", numbers(X.p),
                         exact(part.size.x));
    case Shape::cylinder:
    case Shape::capsule:
      if (!is_upright(X.R)) return std::nullopt;
      return fmt::format("shape: {}, base_m: {}, radius_m: {}, height_m: {}",
                         part.shape == Shape::cylinder ? "cylinder" : "capsule", numbers(X.p),
                         exact(part.size.x), exact(part.size.z));
    case Shape::box:
      if (!is_upright(X.R)) return std::nullopt;
      return box(X.p, part.size, std::atan2(X.R[0].y, X.R[0].x));
    default:
      return std::nullopt;
  }
}

// How a part moves between the instants.
struct Way {
  Vec3 velocity_mps{0.0};
  double off_m = 0;  // By how much its places leave the straight way.
};

Way way_of(const std::vector<SceneAt>& instants, size_t part) {
  Way way;
  const Vec3 from = instants.front().primitives[part].X_WO.p;
  const Vec3 to = instants.back().primitives[part].X_WO.p;
  const double span_s = (instants.back().time - instants.front().time).s();
  if (span_s > 0) way.velocity_mps = (to - from) / span_s;
  for (const SceneAt& at : instants) {
    const double t = (at.time - instants.front().time).s();
    const Vec3 place = at.primitives[part].X_WO.p;
    way.off_m = std::max(way.off_m, glm::length(place - (from + t * way.velocity_mps)));
  }
  return way;
}

}  // namespace

std::string scene_yaml(const std::vector<SceneAt>& instants, const Rgb& background,
                       const Lighting& lighting, SetDraft& draft) {
  constexpr double kStill_m = 1e-4;
  std::string yaml = fmt::format("format: seam-scene/1\nbackground_rgb: [{}, {}, {}]\n",
                                 exact(background[0]), exact(background[1]), exact(background[2]));
  if (lighting.lambert)
    yaml += fmt::format("shading: lambert\nlight: {{direction: {}, ambient: {}, diffuse: {}}}\n",
                        numbers(lighting.direction_W), exact(lighting.ambient),
                        exact(lighting.diffuse));
  yaml += "objects:\n";
  size_t left_out = 0, bent = 0, held = 0;
  double most_m = 0;
  for (size_t i = 0; i < instants.front().primitives.size(); ++i) {
    Primitive part = instants.front().primitives[i];
    Way way = way_of(instants, i);
    if (way.off_m > kStill_m) ++bent, most_m = std::max(most_m, way.off_m);
    const bool moves = way.off_m <= kStill_m && glm::length(way.velocity_mps) > 1e-6;
    // A scene says where things are at time 0.
    if (moves) part.X_WO.p -= instants.front().time.s() * way.velocity_mps;
    const auto shape = shape_of(part);
    if (!shape) {
      ++left_out;
      continue;
    }
    ++held;
    yaml += fmt::format("  - {{{}, rgb: [{}, {}, {}]{}}}\n", *shape, exact(part.rgb[0]),
                        exact(part.rgb[1]), exact(part.rgb[2]),
                        moves ? ", velocity_mps: " + numbers(way.velocity_mps) : "");
  }
  draft.did(fmt::format("scene.yaml has the {} parts of the match that the camera may see", held));
  if (left_out > 0)
    draft.warn(fmt::format(
        "{} parts are left out of scene.yaml, which holds neither what is turned about a level "
        "axis (limbs of robots) nor meshes and textures: where they show, pictures do not fit",
        left_out));
  if (bent > 0)
    draft.warn(fmt::format(
        "{} parts move as scene.yaml cannot say, by up to {:.3g} m: they stand where they were at "
        "the first frame",
        bent, most_m));
  return yaml;
}

}  // namespace seam::app
