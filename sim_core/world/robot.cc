#include "sim_core/world/robot.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"
#include "sim_core/body/turn.h"
#include "sim_core/world/robot_figure.h"

namespace seam {
namespace {

constexpr double kGravity = 9.81;
constexpr double kPawContact = 2e-3;  // A paw this near the ground presses its switch, m.
constexpr double kErs210Reach = 0.5;

// How far from its link's origin a part may reach.
double reach_of(const BodyPart& part) {
  const double size = part.shape == Shape::mesh ? part.size_m.x : glm::length(part.size_m);
  return glm::length(part.centre_m) + size;
}

double reach_of(const RobotBody& body) {
  if (!body.tree.present()) return kErs210Reach;
  double most = 0;
  for (const BodyPart& part : body.parts) most = std::max(most, reach_of(part));
  return most + body.tree.reach_m() + std::abs(body.base_height_m);
}

JointAngles joints_at_start(const RobotSpec& spec) {
  JointAngles initial{};
  const KinematicTree& tree = spec.body.tree;
  for (size_t j = 0; j < tree.joint_count(); ++j) initial[j] = tree.joint(j).start_rad;
  if (tree.present()) return initial;
  gait_angles(spec.body, 0, {}, initial);
  for (size_t j = 0; j < kHeadJoints; ++j) initial[j] = spec.head_rad[j];
  return initial;
}

}  // namespace

Pose2 moved(const Pose2& from, const BodyVelocity& v, double duration_s) {
  const double half_turn = 0.5 * v.omega_radps * duration_s;
  const double chord =
      std::abs(half_turn) < 1e-9 ? duration_s : duration_s * maths::sin(half_turn) / half_turn;
  const double c = maths::cos(from.theta_rad + half_turn),
               s = maths::sin(from.theta_rad + half_turn);
  return {from.x_m + chord * (c * v.vx_mps - s * v.vy_mps),
          from.y_m + chord * (s * v.vx_mps + c * v.vy_mps), from.theta_rad + 2 * half_turn};
}

Pose2 PlanarTrack::at(double fraction) const {
  const size_t pieces = points.size() - 1;
  const double scaled = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(pieces);
  const size_t i = std::min(static_cast<size_t>(scaled), pieces - 1);
  const double f = scaled - static_cast<double>(i);
  const Pose2& a = points[i];
  const Pose2& b = points[i + 1];
  return {a.x_m + f * (b.x_m - a.x_m), a.y_m + f * (b.y_m - a.y_m),
          a.theta_rad + f * (b.theta_rad - a.theta_rad)};
}

void PlanarTrack::visit(StateVisitor& visitor) {
  for (Pose2& point : points) {
    visitor.field("x_m", point.x_m);
    visitor.field("y_m", point.y_m);
    visitor.field("theta_rad", point.theta_rad);
  }
}

Robot::Robot(const RobotSpec& spec, const RobotPartsFactory& parts, RandomStream stream,
             size_t substeps)
    : spec_(&spec), reach_m_(reach_of(spec.body)) {
  const JointAngles initial = joints_at_start(spec);
  for (size_t j = 0; j < spec.body.joint_count(); ++j) {
    joints_.push_back(parts.joint(spec, static_cast<int>(j), initial[j],
                                  stream.child("joint").child(static_cast<uint64_t>(j))));
  }
  locomotion_ = parts.locomotion(spec, stream.child("locomotion"));
  track.points.assign(substeps + 1, spec.pose);
  dead_reckoning_.points.assign(substeps + 1, Pose2{});
  attitude_.fill(attitude(SimTime()));
  origin_.fill(body_pose(spec.pose, 1).p);
}

double Robot::top_speed(int joint) const {
  const bool of_head = !spec_->body.tree.present() && joint < kHeadJoints;
  if (of_head && spec_->head_speed_radps > 0) return spec_->head_speed_radps;
  return spec_->body.joints[static_cast<size_t>(joint)].speed_radps;
}

void Robot::command_joint(SimTime time, int joint, double angle_rad, double speed_radps) {
  const JointLimits& limits = spec_->body.joints[static_cast<size_t>(joint)];
  const double top = top_speed(joint);
  joints_[static_cast<size_t>(joint)]->command(
      time, std::clamp(angle_rad, limits.min_rad, limits.max_rad),
      speed_radps > 0 ? std::min(speed_radps, top) : top);
}

void Robot::apply(const RobotCommand& command, SimTime time, SimTime interval_end) {
  const bool stays = spec_->body.tree.present() && !spec_->body.moves;
  if (command.walk && !stays) {
    const Gait& gait = spec_->body.gait;
    const double share = std::max({1.0, std::abs(command.walk->vx_mps) / gait.max_vx_mps,
                                   std::abs(command.walk->vy_mps) / gait.max_vy_mps,
                                   std::abs(command.walk->omega_radps) / gait.max_omega_radps});
    walk_ = {command.walk->vx_mps / share, command.walk->vy_mps / share,
             command.walk->omega_radps / share};
    legs_commanded_ = false;
  }
  for (const JointFrame& frame : command.joints) {
    for (const JointTarget& target : frame.targets) {
      if (static_cast<size_t>(target.joint) >= joints_.size())
        throw InputError(fmt::format("robot '{}' has no joint {}", spec_->id, target.joint));
      if (kicks_with(target.joint, time + frame.offset)) continue;
      // A new decision replaces what an earlier one had planned for this joint.
      if (&frame == &command.joints.front()) {
        std::erase_if(pending_,
                      [&](const Pending& p) { return p.joint == target.joint && p.time >= time; });
      }
      if (spec_->body.is_leg(target.joint)) legs_commanded_ = true;
      plan({time + frame.offset, target.joint, target.angle_rad, target.speed_radps}, interval_end);
    }
  }
  give_due(interval_end);
}

void Robot::plan(Pending next, SimTime interval_end) {
  if (spec_->body.is_leg(static_cast<int>(next.joint)))
    next.time = std::max(next.time, interval_end);
  const auto behind = [&](const Pending& p) { return p.time > next.time; };
  pending_.insert(std::find_if(pending_.begin(), pending_.end(), behind), next);
}

void Robot::begin_kick(const KickSpec& kick, SimTime time, SimTime interval_end) {
  kick_joints_ = 0;
  kick_end_ = time + SimDuration::from_s(kick.duration_s);
  for (const KickMotion& motion : kick.motion) kick_joints_ |= int64_t{1} << motion.joint;
  std::erase_if(pending_,
                [&](const Pending& p) { return kicks_with(static_cast<int>(p.joint), p.time); });
  for (const KickMotion& motion : kick.motion) {
    plan({time + SimDuration::from_s(motion.at_s), static_cast<int64_t>(motion.joint),
          motion.angle_rad, 0},
         interval_end);
  }
  give_due(interval_end);
}

void Robot::freeze(SimTime time) {
  pending_.clear();
  walk_ = {};
  for (int j = 0; j < static_cast<int>(joints_.size()); ++j)
    if (!spec_->body.is_leg(j)) command_joint(time, j, joint_angle(j, time), 0);
}

void Robot::give_due(SimTime end) {
  size_t due = 0;
  for (; due < pending_.size() && pending_[due].time < end; ++due) {
    const Pending& p = pending_[due];
    command_joint(p.time, static_cast<int>(p.joint), p.angle_rad, p.speed_radps);
  }
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(due));
}

void Robot::begin_interval(SimTime start, SimTime end) {
  for (const auto& joint : joints_) joint->forget_before(start);
  track.points.front() = track.points.back();
  track.points.front().theta_rad = maths::wrap_angle(track.points.front().theta_rad);
  dead_reckoning_.points.front() = dead_reckoning_.points.back();
  if (!legs_commanded_ && !spec_->body.tree.present()) command_gait(start, end);
  give_due(end);
  attitude_ = {attitude_[1], attitude(end)};
}

// Legs go evenly to where the gait wants them at the interval's end.
void Robot::command_gait(SimTime start, SimTime end) {
  const double h = (end - start).s();
  const Gait& gait = spec_->body.gait;
  const double follow = 1 - maths::exp(-h / gait.settle_s);
  stride_.vx_mps += follow * (walk_.vx_mps - stride_.vx_mps);
  stride_.vy_mps += follow * (walk_.vy_mps - stride_.vy_mps);
  stride_.omega_radps += follow * (walk_.omega_radps - stride_.omega_radps);
  gait_phase_ += h / gait.step_s;
  gait_phase_ -= std::floor(gait_phase_);
  JointAngles target{};
  gait_angles(spec_->body, gait_phase_, stride_, target);
  for (int j = kHeadJoints; j < kJoints; ++j) {
    if (kicks_with(j, start)) continue;
    const double way = std::abs(target[static_cast<size_t>(j)] - joint_angle(j, start));
    if (way > 0) command_joint(start, j, target[static_cast<size_t>(j)], way / h);
  }
}

BodyVelocity Robot::drive(size_t k, SimTime start, SimDuration step, bool may_walk) {
  const BodyVelocity commanded = may_walk ? walk_ : BodyVelocity{};
  dead_reckoning_.points[k + 1] = moved(dead_reckoning_.points[k], commanded, step.s());
  return locomotion_->velocity(commanded, start, step);
}

void Robot::end_interval() {
  origin_ = {origin_[1], origin_[2], body_pose(track.points.back(), 1).p};
}

JointAngles Robot::joint_angles(SimTime time) const {
  JointAngles angles{};
  for (size_t j = 0; j < joints_.size(); ++j) angles[j] = joints_[j]->angle(time);
  return angles;
}

JointAngles Robot::camera_joint_angles(SimTime time) const {
  if (spec_->body.tree.present()) return joint_angles(time);
  JointAngles angles{};
  for (int j = 0; j < kHeadJoints; ++j) angles[static_cast<size_t>(j)] = joint_angle(j, time);
  return angles;
}

Attitude Robot::attitude(SimTime time) const {
  if (spec_->body.tree.present()) return {.height_m = spec_->body.base_height_m};
  return attitude_on_paws(spec_->body, paws(time));
}

std::array<Vec3, kLegs> Robot::paws(SimTime time) const {
  const JointAngles joints = joint_angles(time);
  std::array<Vec3, kLegs> paws;
  for (int leg = 0; leg < kLegs; ++leg)
    paws[static_cast<size_t>(leg)] = leg_pose(spec_->body, leg, joints).p_BPaw;
  return paws;
}

SensorTruth Robot::sense(SimTime time, double fraction, SimDuration interval) const {
  SensorTruth truth;
  for (size_t j = 0; j < joints_.size(); ++j) truth.encoders_rad[j] = joints_[j]->encoder(time);
  truth.dead_reckoning = dead_reckoning_.at(fraction);
  const Pose X_WB = body_pose(track.at(fraction), fraction);
  const double h = interval.s();
  const Vec3 acceleration_W = (origin_[2] - 2.0 * origin_[1] + origin_[0]) / (h * h);
  truth.motion_B.force_mps2 = glm::transpose(X_WB.R) * (acceleration_W + Vec3(0, 0, kGravity));
  if (spec_->sensors.gyroscope)
    truth.motion_B.rate_radps = turn_of(glm::transpose(body_pose(track.points.front(), 0).R) *
                                        body_pose(track.points.back(), 1).R) /
                                h;
  if (spec_->body.tree.present()) return truth;
  const auto paws_B = paws(time);
  for (size_t i = 0; i < kLegs; ++i) {
    truth.paw_contact[i] = (X_WB * paws_B[i]).z - spec_->body.paw_radius_m < kPawContact;
  }
  return truth;
}

Posture Robot::posture(const Pose2& place, double fraction, SimTime time) const {
  Posture posture = body_posture(place, fraction);
  posture.joints_rad = joint_angles(time);
  return posture;
}

Posture Robot::body_posture(const Pose2& place, double fraction) const {
  const double f = std::clamp(fraction, 0.0, 1.0);
  const auto between = [f](double a, double b) { return a + f * (b - a); };
  const Attitude &a = attitude_[0], &b = attitude_[1];
  return {.turn_rad = {between(a.roll_rad, b.roll_rad), between(a.pitch_rad, b.pitch_rad),
                       place.theta_rad},
          .p_WB = {place.x_m, place.y_m, between(a.height_m, b.height_m)}};
}

Pose Robot::body_pose(const Pose2& place, double fraction) const {
  return body_pose_of(body_posture(place, fraction));
}

void Robot::place(const Pose2& pose) {
  for (Pose2& point : track.points) point = pose;
  origin_.fill(body_pose(pose, 1).p);
}

void Attitude::visit(StateVisitor& visitor) {
  visitor.field("height_m", height_m);
  visitor.field("pitch_rad", pitch_rad);
  visitor.field("roll_rad", roll_rad);
}

void Robot::Pending::visit(StateVisitor& visitor) {
  visitor.field("pending_time", time);
  visitor.field("pending_joint", joint);
  visitor.field("pending_angle_rad", angle_rad);
  visitor.field("pending_speed_radps", speed_radps);
}

void Robot::visit(StateVisitor& visitor) {
  track.visit(visitor);
  dead_reckoning_.visit(visitor);
  for (Attitude& attitude : attitude_) attitude.visit(visitor);
  for (Vec3& origin : origin_) {
    visitor.field("origin_x_m", origin.x);
    visitor.field("origin_y_m", origin.y);
    visitor.field("origin_z_m", origin.z);
  }
  for (size_t j = 0; j < joints_.size(); ++j) {
    visitor.scope(spec_->body.joint_name(j));
    joints_[j]->visit(visitor);
  }
  visitor.scope("locomotion");
  locomotion_->visit(visitor);
  visitor.scope("");
  visitor.list("pending", pending_);
  for (const Pending& p : pending_) {
    if (p.joint < 0 || p.joint >= static_cast<int64_t>(joints_.size()))
      throw InputError("snapshot: a command to an unknown joint");
  }
  walk_.visit(visitor);
  visitor.field("kick_joints", kick_joints_);
  visitor.field("kick_end", kick_end_);
  visitor.field("gait_phase", gait_phase_);
  stride_.visit(visitor);
  visitor.field("legs_commanded", legs_commanded_);
}

}  // namespace seam
