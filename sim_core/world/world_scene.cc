// What the world looks like at an instant.
#include <cmath>

#include "sim_core/base/maths.h"
#include "sim_core/world/world_impl.h"

namespace seam {
namespace {

constexpr uint16_t kBallId = 1;
constexpr uint16_t kFirstRobotId = 2;
constexpr uint16_t kFirstObjectId = 100;
constexpr uint16_t kFirstFieldId = 2000;

}  // namespace

void World::Impl::make_scenery() {
  if (scenario.has_field) scenery = field_primitives(scenario.field, kFirstFieldId);
  uint16_t id = kFirstObjectId;
  for (const ObjectSpec& object : scenario.objects) {
    const bool stands = objects.empty() && object.velocity_mps == Vec3(0.0);
    for (const Primitive& part : primitives_of(object, id)) {
      if (stands)
        scenery.push_back(part);
      else
        objects.push_back({part, object.velocity_mps});
    }
    ++id;
  }
  for (size_t i = 0; i < robots.size(); ++i) {
    const auto robot_id = static_cast<uint16_t>(kFirstRobotId + i);
    figures.emplace_back(robots[i].spec(), robot_id, RobotFigure::Parts::all);
    own_figures.emplace_back(robots[i].spec(), robot_id, RobotFigure::Parts::before_own_lens);
  }
}

void World::Impl::add_objects(SimTime time, std::vector<Primitive>& out) const {
  for (const MovingPart& part : objects) {
    out.push_back(part.at_zero);
    out.back().X_WO.p += time.s() * part.velocity_mps;
  }
}

void World::Impl::add_ball(SimTime time, std::vector<Primitive>& out) const {
  if (!scenario.ball.present) return;
  out.push_back({.shape = Shape::sphere,
                 .label = Label::ball,
                 .object_id = kBallId,
                 .X_WO = translation(ball_at(time)),
                 .size = {0.5 * scenario.ball.diameter_m, 0, 0},
                 .rgb = scenario.field.colours.orange});
}

Posture World::Impl::posture_of(size_t robot, SimTime time) const {
  return robots[robot].posture(robots[robot].track.at(fraction(time)), fraction(time), time);
}

// Whether a robot stands wholly behind the camera, with a margin for lenses that look sideways.
bool World::Impl::behind(const Pose& X_WL, size_t robot, SimTime time) const {
  const Pose2 place = robots[robot].track.at(fraction(time));
  const Vec3 p_L = glm::transpose(X_WL.R) * (Vec3(place.x_m, place.y_m, X_WL.p.z) - X_WL.p);
  return p_L.x < -robots[robot].reach_m();
}

const std::vector<Primitive>& World::scenery() const {
  return impl_->scenery;
}

void World::primitives_at(SimTime time, std::vector<Primitive>& out) const {
  out.insert(out.end(), impl_->scenery.begin(), impl_->scenery.end());
  impl_->add_objects(time, out);
  impl_->add_ball(time, out);
  for (size_t i = 0; i < impl_->robots.size(); ++i)
    impl_->figures[i].add_parts(impl_->posture_of(i, time), out);
}

// This is called for each instant of each frame.
SceneInstant World::view_of(size_t robot, SimTime time, const Pose& X_LC) const {
  const Pose X_WL = camera_link_pose(robot, time);
  SceneInstant view{.time = time, .X_WC = X_WL * X_LC, .primitives = {}, .figures = {}};
  impl_->add_objects(time, view.primitives);
  impl_->add_ball(time, view.primitives);
  view.figures.reserve(impl_->robots.size());
  for (size_t i = 0; i < impl_->robots.size(); ++i) {
    if (i != robot && impl_->behind(X_WL, i, time)) continue;
    const RobotFigure& figure = i == robot ? impl_->own_figures[i] : impl_->figures[i];
    view.figures.push_back({&figure, impl_->posture_of(i, time)});
  }
  return view;
}

Pose World::camera_link_pose(size_t index, SimTime time) const {
  const Robot& robot = impl_->robots.at(index);
  return robot.body_pose(robot.track.at(impl_->fraction(time)), impl_->fraction(time)) *
         seam::camera_link_pose(robot.spec().body, robot.camera_joint_angles(time));
}

}  // namespace seam
