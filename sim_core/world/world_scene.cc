// What the world looks like at an instant.
#include <cmath>

#include "sim_core/base/maths.h"
#include "sim_core/world/world_impl.h"

namespace seam {
namespace {

constexpr uint16_t kBallId = 1;
constexpr uint16_t kFirstRobotId = 2;
constexpr uint16_t kFirstObjectId = 100;

// What holds the camera is not in its pictures.
bool is_behind_lens(const RobotBody& body, const BodyPart& part) {
  if (body.tree.present()) return !body.tree.sees_own_link && part.link == body.tree.camera_place();
  const auto link = static_cast<Link>(part.link);
  return link == Link::head || link == Link::neck;
}

Label uniform_label(Team team) {
  return team == Team::red ? Label::robot_red : Label::robot_blue;
}

}  // namespace

void World::Impl::make_objects() {
  uint16_t id = kFirstObjectId;
  for (const ObjectSpec& object : scenario.objects) {
    for (const Primitive& part : primitives_of(object, id))
      objects.push_back({part, object.velocity_mps});
    ++id;
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

void World::Impl::add_robot(size_t index, SimTime time, bool is_viewer,
                            std::vector<Primitive>& out) const {
  const Robot& robot = robots[index];
  const RobotSpec& spec = robot.spec();
  const Pose X_WB = robot.body_pose(robot.track.at(fraction(time)), fraction(time));
  auto X_WLinks = link_poses(spec.body, robot.joint_angles(time));
  for (Pose& X : X_WLinks) X = X_WB * X;
  const Rgb& uniform = spec.team == Team::red ? spec.body.red_rgb : spec.body.blue_rgb;
  for (size_t i = 0; i < spec.body.parts.size(); ++i) {
    const BodyPart& part = spec.body.parts[i];
    if (is_viewer && is_behind_lens(spec.body, part)) continue;
    const bool team = part.paint == Paint::team;
    out.push_back({.shape = part.shape,
                   .label = team ? uniform_label(spec.team) : Label::robot_body,
                   .object_id = static_cast<uint16_t>(kFirstRobotId + index),
                   .X_WO = X_WLinks[part.link] * robot.part_poses()[i],
                   .size = part.size_m,
                   .rgb = team                       ? uniform
                          : part.paint == Paint::own ? part.rgb
                                                     : spec.body.body_rgb,
                   .asset = part.asset});
  }
}

// Whether a robot stands wholly behind the camera, with a margin for lenses that look sideways.
bool World::Impl::behind(const Pose& X_WL, size_t robot, SimTime time) const {
  const Pose2 place = robots[robot].track.at(fraction(time));
  const Vec3 p_L = glm::transpose(X_WL.R) * (Vec3(place.x_m, place.y_m, X_WL.p.z) - X_WL.p);
  return p_L.x < -robots[robot].reach_m();
}

void World::primitives_at(SimTime time, std::vector<Primitive>& out,
                          std::optional<size_t> viewer) const {
  // This is called for each instant of each frame.
  size_t parts = 0;
  for (const Robot& robot : impl_->robots) parts += robot.spec().body.parts.size();
  out.reserve(out.size() + impl_->fixed.size() + parts + 16);
  out.insert(out.end(), impl_->fixed.begin(), impl_->fixed.end());
  impl_->add_objects(time, out);
  impl_->add_ball(time, out);
  const Pose X_WL = viewer ? camera_link_pose(*viewer, time) : Pose{};
  for (size_t i = 0; i < impl_->robots.size(); ++i) {
    if (viewer && i != *viewer && impl_->behind(X_WL, i, time)) continue;
    impl_->add_robot(i, time, viewer == i, out);
  }
}

Pose World::camera_link_pose(size_t index, SimTime time) const {
  const Robot& robot = impl_->robots.at(index);
  return robot.body_pose(robot.track.at(impl_->fraction(time)), impl_->fraction(time)) *
         seam::camera_link_pose(robot.spec().body, robot.camera_joint_angles(time));
}

}  // namespace seam
