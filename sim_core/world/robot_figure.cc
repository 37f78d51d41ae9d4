#include "sim_core/world/robot_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "sim_core/base/maths.h"
#include "sim_core/scene/bounding_ball.h"

namespace seam {
namespace {

static_assert(std::is_same_v<decltype(Posture::joints_rad), JointAngles>);

bool is_behind_lens(const RobotBody& body, const BodyPart& part) {
  if (body.tree.present()) return !body.tree.sees_own_link && part.link == body.tree.camera_place();
  const auto link = static_cast<Link>(part.link);
  return link == Link::head || link == Link::neck;
}

Label uniform_label(Team team) {
  return team == Team::red ? Label::robot_red : Label::robot_blue;
}

Primitive on_link(const RobotSpec& spec, const BodyPart& part, uint16_t object_id) {
  const bool team = part.paint == Paint::team;
  const Rgb& uniform = spec.team == Team::red ? spec.body.red_rgb : spec.body.blue_rgb;
  const Vec3& turn = part.rotate_rad;
  return {.shape = part.shape,
          .label = team ? uniform_label(spec.team) : Label::robot_body,
          .object_id = object_id,
          .X_WO = {rotation_zyx(turn.x, turn.y, turn.z), part.centre_m},
          .size = part.size_m,
          .rgb = team                       ? uniform
                 : part.paint == Paint::own ? part.rgb
                                            : spec.body.body_rgb,
          .asset = part.asset};
}

// How far the ball about the primitive reaches from the origin of what holds it.
double extent_m(const Primitive& primitive) {
  return glm::length(primitive.X_WO * bounding_centre(primitive)) + bounding_radius(primitive);
}

}  // namespace

Pose body_pose_of(const Posture& posture) {
  return {rotation_zyx(posture.turn_rad.x, posture.turn_rad.y, posture.turn_rad.z), posture.p_WB};
}

RobotFigure::RobotFigure(const RobotSpec& spec, uint16_t object_id, Parts parts)
    : body_(&spec.body) {
  const RobotBody& body = *body_;
  const double shoulder_m = maths::length(body.shoulder_x_m, body.shoulder_y_m);
  const double upper_m = maths::length(body.upper_leg_offset_m, body.upper_leg_m);
  for (const BodyPart& part : body.parts) {
    if (parts == Parts::before_own_lens && is_behind_lens(body, part)) continue;
    parts_.push_back({&part, on_link(spec, part, object_id)});
    const double extent = extent_m(parts_.back().on_link);
    double from_body_m = extent;
    if (body.tree.present()) {
      tree_reach_m_ = std::max(tree_reach_m_, body.tree.reach_m() + extent);
      from_body_m = tree_reach_m_;
    } else if (part.link >= static_cast<size_t>(Link::left_front_upper)) {
      leg_reach_m_ = std::max(leg_reach_m_, upper_m + extent);
      from_body_m = shoulder_m + upper_m + extent;
    } else if (static_cast<Link>(part.link) != Link::body) {
      head_reach_m_ = std::max(head_reach_m_, body.roll_height_m + extent);
      from_body_m = glm::length(body.tilt_axis_m) + body.roll_height_m + extent;
    }
    radius_m_ = std::max(radius_m_, from_body_m);
  }
  // Whoever compares it has rounded.
  radius_m_ *= 1 + 1e-9;
}

void RobotFigure::add_parts(const Posture& posture, std::vector<Primitive>& out) const {
  const Pose X_WB = body_pose_of(posture);
  std::vector<Pose> X_WLinks = link_poses(*body_, posture.joints_rad);
  for (Pose& X : X_WLinks) X = X_WB * X;
  for (const Part& part : parts_) {
    out.push_back(part.on_link);
    out.back().X_WO = X_WLinks[part.part->link] * part.on_link.X_WO;
  }
}

std::string RobotFigure::part_name(size_t index) const {
  const BodyPart& part = *parts_.at(index).part;
  const std::string link = body_->tree.present()
                               ? fmt::format("link '{}'", body_->tree.links[part.link].name)
                               : fmt::format("a {}", body_->name);
  if (part.shape == Shape::mesh) return fmt::format("the mesh '{}' of {}", part.mesh.name, link);
  return fmt::format("the {} of {}", shape_name(part.shape), link);
}

double RobotFigure::joints_motion_bound_m(const JointAngles& a, const JointAngles& b) const {
  if (body_->tree.present()) return body_->tree.motion_bound_m(a, b, tree_reach_m_);
  const auto turned_rad = [&](int first, int count) {
    double sum = 0;
    for (auto j = static_cast<size_t>(first); j < static_cast<size_t>(first + count); ++j)
      sum += std::abs(b[j] - a[j]);
    return sum;
  };
  double most = head_reach_m_ * turned_rad(0, kHeadJoints);
  for (int leg = 0; leg < kLegs; ++leg)
    most = std::max(most, leg_reach_m_ * turned_rad(leg_joint(leg, 0), kJointsALeg));
  return most;
}

double RobotFigure::motion_bound_m(const Posture& a, const Posture& b) const {
  const Vec3 step = b.p_WB - a.p_WB, turn = b.turn_rad - a.turn_rad;
  const double turned_rad = std::abs(turn.x) + std::abs(turn.y) + std::abs(turn.z);
  return std::sqrt(glm::dot(step, step)) + radius_m_ * turned_rad +
         joints_motion_bound_m(a.joints_rad, b.joints_rad);
}

}  // namespace seam
