#include "render/cast/scene_motion.h"

#include <algorithm>
#include <cmath>

#include "render/cast/prepared_scene.h"

namespace seam::render {
namespace {

// Nothing is seen closer than this: the robot's own nose is.
constexpr double kNearest_m = 0.1;

double angle_between(const Mat3& a, const Mat3& b) {
  // |R_a - R_b| (Frobenius) is sqrt(8) sin(angle / 2); the arc is at most pi/2 times its chord.
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += glm::dot(a[k] - b[k], a[k] - b[k]);
  const double chord = std::sqrt(sum / 2);
  return chord < 0.5 ? chord * 1.011 : chord * 1.571;
}

Pose between(const Pose& a, const Pose& b, double fraction) {
  Pose pose{a.R, a.p + fraction * (b.p - a.p)};
  if (a.R == b.R) return pose;
  Vec3 x = a.R[0] + fraction * (b.R[0] - a.R[0]);
  Vec3 y = a.R[1] + fraction * (b.R[1] - a.R[1]);
  x /= std::sqrt(glm::dot(x, x));
  y -= glm::dot(x, y) * x;
  y /= std::sqrt(glm::dot(y, y));
  pose.R = Mat3(x, y, glm::cross(x, y));
  return pose;
}

// Calls f(from, to) for each primitive of both instants. They come in the same order, but what
// stands behind the camera may be left out of either, whole objects at a time
// (World::primitives_at).
template <typename F>
void for_each_pair(const std::vector<Primitive>& a, const std::vector<Primitive>& b, F&& f) {
  for (size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (a[i].object_id == b[j].object_id && a[i].shape == b[j].shape) {
      f(i++, j++);
      continue;
    }
    size_t found = j;
    while (found < b.size() && b[found].object_id != a[i].object_id) ++found;
    if (found < b.size() && found > j) {
      j = found;
    } else {
      ++i;
    }
  }
}

}  // namespace

SceneInstant interpolate(const SceneInstant& a, const SceneInstant& b, SimTime time) {
  const double span = static_cast<double>((b.time - a.time).ns());
  const double fraction = span == 0 ? 0 : static_cast<double>((time - a.time).ns()) / span;
  SceneInstant scene = fraction < 0.5 ? a : b;
  scene.time = time;
  scene.X_WC = between(a.X_WC, b.X_WC, fraction);
  // A primitive that exists at one of the instants alone stays as the nearer instant has it.
  for_each_pair(a.primitives, b.primitives, [&](size_t from, size_t to) {
    scene.primitives[fraction < 0.5 ? from : to].X_WO =
        between(a.primitives[from].X_WO, b.primitives[to].X_WO, fraction);
  });
  return scene;
}

double image_motion_bound_px(const SceneInstant& a, const SceneInstant& b, double focal_px) {
  const Vec3 camera_step = b.X_WC.p - a.X_WC.p;
  constexpr double kNearest2 = kNearest_m * kNearest_m;
  double most2 = glm::dot(camera_step, camera_step) / kNearest2;
  for_each_pair(a.primitives, b.primitives, [&](size_t from, size_t to) {
    const Primitive& primitive = a.primitives[from];
    const Pose& X_WA = primitive.X_WO;
    const Pose& X_WB = b.primitives[to].X_WO;
    if (X_WA.p == X_WB.p && X_WA.R == X_WB.R) return;
    // A point within `reach` of the origin moves no further than the origin and `reach` times the
    // turn, whose square is at most 1.571^2 / 2 times that of the rotations' difference; and
    // (p + q)^2 <= 2 (p^2 + q^2).
    const double reach = primitive.size.x + primitive.size.y + primitive.size.z;
    const Vec3 step = X_WB.p - X_WA.p - camera_step, from_camera = X_WA.p - a.X_WC.p;
    double turned2 = 0;
    for (int k = 0; k < 3; ++k) {
      const Vec3 change = X_WA.R[k] - X_WB.R[k];
      turned2 += glm::dot(change, change);
    }
    const double moved2 = 2 * (glm::dot(step, step) + 1.2341 * turned2 * (reach * reach));
    // Of a small object no point is nearer than half as far as its origin.
    const double away2 = 0.25 * glm::dot(from_camera, from_camera);
    const double nearest2 = away2 > reach * reach ? std::max(away2, kNearest2) : kNearest2;
    if (moved2 > most2 * nearest2) most2 = moved2 / nearest2;
  });
  return focal_px * (angle_between(a.X_WC.R, b.X_WC.R) + std::sqrt(most2));
}

double image_motion_px(const SceneInstant& a, const SceneInstant& b, double focal_px) {
  const double turned = angle_between(a.X_WC.R, b.X_WC.R);
  const Vec3 camera_step = b.X_WC.p - a.X_WC.p;
  double shifted = std::sqrt(glm::dot(camera_step, camera_step)) / kNearest_m;
  for_each_pair(a.primitives, b.primitives, [&](size_t from, size_t to) {
    const Pose& X_WA = a.primitives[from].X_WO;
    const Pose& X_WB = b.primitives[to].X_WO;
    if (X_WA.p == X_WB.p && X_WA.R == X_WB.R) return;
    const Vec3 centre_O = bounding_centre(a.primitives[from]);
    const double radius = bounding_radius(a.primitives[from]);
    const Vec3 step = X_WB * centre_O - X_WA * centre_O - camera_step;
    const Vec3 from_camera = X_WA * centre_O - a.X_WC.p;
    const double distance =
        std::max(std::sqrt(glm::dot(from_camera, from_camera)) - radius, kNearest_m);
    const double moved = std::sqrt(glm::dot(step, step)) + angle_between(X_WA.R, X_WB.R) * radius;
    shifted = std::max(shifted, moved / distance);
  });
  return focal_px * (turned + shifted);
}

}  // namespace seam::render
