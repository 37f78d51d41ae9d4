// How a scene moves between two instants.
#pragma once

#include <functional>

#include "sim_core/scene/scene.h"

namespace seam::render {

// The pose at this fraction of the way from a to b.
Pose between(const Pose& a, const Pose& b, double fraction);

// The scene at `time` between (or a little beyond) two instants of nothing but primitives: poses
// are interpolated, which is exact for constant velocities and good to the third power of the angle
// turned in between.
SceneInstant interpolate(const SceneInstant& a, const SceneInstant& b, SimTime time);
// Where `time` lies between the two.
double fraction_between(const SceneInstant& a, const SceneInstant& b, SimTime time);

// An upper bound of how far any visible point moves in the image while the camera goes from one
// pose to another; of what else moves as far as it was added. In multiples of the focal length.
class ImageMotion {
 public:
  // Whether a primitive can be seen at one of the two instants; what can not is not added.
  using InSight = std::function<bool(const Primitive& from, const Primitive& to)>;
  ImageMotion(const Pose& X_WC_from, const Pose& X_WC_to, InSight in_sight = nullptr);

  double most() const { return turned_ + shifted_; }
  void add(const Primitive& from, const Primitive& to);
  // Primitives of both in their order; what either lacks (objects that stand behind the camera may
  // be left out) is no motion.
  void add_all(const std::vector<Primitive>& from, const std::vector<Primitive>& to);
  // What `most` were at the most if a figure had been added that is this ball and moves no further.
  double most_with(const Vec3& p_W, double radius_m, double moved_m) const;

 private:
  InSight in_sight_;
  Vec3 camera_, camera_step_;
  double turned_;
  double shifted_;
};

}  // namespace seam::render
