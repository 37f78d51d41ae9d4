#include "render/cast/scene_motion.h"

#include <algorithm>
#include <cmath>

#include "sim_core/scene/bounding_ball.h"

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

// Whether a primitive surely moves by less than `shifted`: at less work than how far it moves.
bool moves_less(const Primitive& from, const Pose& X_WB, const Vec3& camera,
                const Vec3& camera_step, double shifted) {
  // A point within `reach` of the origin moves no further than the origin and `reach` times the
  // turn, whose square is at most 1.571^2 / 2 times that of the rotations' difference; and
  // (p + q)^2 <= 2 (p^2 + q^2).
  const Pose& X_WA = from.X_WO;
  const double reach = from.size.x + from.size.y + from.size.z;
  const Vec3 step = X_WB.p - X_WA.p - camera_step, from_camera = X_WA.p - camera;
  double turned2 = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 change = X_WA.R[k] - X_WB.R[k];
    turned2 += glm::dot(change, change);
  }
  const double moved2 = 2 * (glm::dot(step, step) + 1.2341 * turned2 * (reach * reach));
  // Of a small object no point is nearer than half as far as its origin.
  constexpr double kNearest2 = kNearest_m * kNearest_m;
  const double away2 = 0.25 * glm::dot(from_camera, from_camera);
  const double nearest2 = away2 > reach * reach ? std::max(away2, kNearest2) : kNearest2;
  return moved2 <= shifted * shifted * nearest2;
}

// Calls f(from, to) for each primitive of both instants. They come in the same order, but what
// stands behind the camera may be left out of either, whole objects at a time
// (World::view_of).
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

double fraction_between(const SceneInstant& a, const SceneInstant& b, SimTime time) {
  const double span = static_cast<double>((b.time - a.time).ns());
  return span == 0 ? 0 : static_cast<double>((time - a.time).ns()) / span;
}

SceneInstant interpolate(const SceneInstant& a, const SceneInstant& b, SimTime time) {
  const double fraction = fraction_between(a, b, time);
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

ImageMotion::ImageMotion(const Pose& X_WC_from, const Pose& X_WC_to, InSight in_sight)
    : in_sight_(std::move(in_sight)),
      camera_(X_WC_from.p),
      camera_step_(X_WC_to.p - X_WC_from.p),
      turned_(angle_between(X_WC_from.R, X_WC_to.R)),
      shifted_(std::sqrt(glm::dot(camera_step_, camera_step_)) / kNearest_m) {}

void ImageMotion::add(const Primitive& from, const Primitive& to) {
  const Pose& X_WA = from.X_WO;
  const Pose& X_WB = to.X_WO;
  if (X_WA.p == X_WB.p && X_WA.R == X_WB.R) return;
  if (moves_less(from, X_WB, camera_, camera_step_, shifted_)) return;
  const Vec3 centre_O = bounding_centre(from);
  const double radius = bounding_radius(from);
  const Vec3 step = X_WB * centre_O - X_WA * centre_O - camera_step_;
  const Vec3 from_camera = X_WA * centre_O - camera_;
  const double distance =
      std::max(std::sqrt(glm::dot(from_camera, from_camera)) - radius, kNearest_m);
  const double moved = std::sqrt(glm::dot(step, step)) + angle_between(X_WA.R, X_WB.R) * radius;
  if (moved / distance > shifted_ && (!in_sight_ || in_sight_(from, to)))
    shifted_ = moved / distance;
}

void ImageMotion::add_all(const std::vector<Primitive>& from, const std::vector<Primitive>& to) {
  for_each_pair(from, to, [&](size_t i, size_t j) { add(from[i], to[j]); });
}

double ImageMotion::most_with(const Vec3& p_W, double radius_m, double moved_m) const {
  // What `add` takes for the motion of a part is its centre's and for its turn at most 1.571 times
  // that of the farthest points of the ball about it: less than 2.6 times what bounds them both.
  const Vec3 from_camera = p_W - camera_;
  const double distance =
      std::max(std::sqrt(glm::dot(from_camera, from_camera)) - radius_m, kNearest_m);
  const double step = std::sqrt(glm::dot(camera_step_, camera_step_));
  return turned_ + std::max(shifted_, (2.6 * moved_m + step) / distance);
}

}  // namespace seam::render
