#include "robot_sdk/team/world_model.h"

#include <cmath>

namespace seam::sdk {
namespace {

constexpr float kMateMemory_s = 2.0f;

}  // namespace

float BallBelief::distance_m() const { return std::sqrt(x_m * x_m + y_m * y_m); }
float BallBelief::bearing_rad() const { return std::atan2(y_m, x_m); }

WorldModel::WorldModel(int player, bool attacks_skyblue, uint64_t seed)
    : player_(player),
      attacks_skyblue_(attacks_skyblue),
      filter_({.particles = 400, .seed = seed}, standard_landmarks()) {
  pose_ = filter_.estimate();
}

void WorldModel::update(const Percepts& percepts) {
  time_s_ = percepts.time_s;
  // The ball stays where it is while the body moves under it.
  const FieldPose& step = percepts.odometry_step;
  const float c = std::cos(step.theta_rad), s = std::sin(step.theta_rad);
  const float x = ball_.x_m - step.x_m, y = ball_.y_m - step.y_m;
  ball_.x_m = c * x + s * y;
  ball_.y_m = -s * x + c * y;

  filter_.move(step.x_m, step.y_m, step.theta_rad);
  if (!percepts.landmarks.empty()) filter_.observe(percepts.landmarks);
  pose_ = filter_.estimate();

  for (const TeamMessage& message : percepts.messages) {
    if (message.player < 0 || message.player >= kTeamSize || message.player == player_) continue;
    mates_[message.player] = {message, time_s_};
  }
  take_ball(percepts);
}

void WorldModel::take_ball(const Percepts& percepts) {
  if (percepts.ball) {
    const float x = percepts.ball->distance_m * std::cos(percepts.ball->bearing_rad);
    const float y = percepts.ball->distance_m * std::sin(percepts.ball->bearing_rad);
    // A ball seen a moment ago is smoothed; after a gap the new sighting stands alone.
    const float trust = ball_age_s() < 0.2f && !ball_.told ? 0.6f : 1.0f;
    ball_ = {ball_.x_m + trust * (x - ball_.x_m), ball_.y_m + trust * (y - ball_.y_m), time_s_, false};
    return;
  }
  if (ball_age_s() < 2.0f) return;
  // Not seen for a while: believe the team mate that is nearest to it.
  const Mate* best = nullptr;
  for (const Mate& mate : mates_) {
    if (!mate.message.sees_ball || time_s_ - mate.heard_s > 0.5f) continue;
    if (best == nullptr || mate.message.ball_distance_m < best->message.ball_distance_m) best = &mate;
  }
  if (best == nullptr) return;
  field_to_body(best->message.ball_x_m, best->message.ball_y_m, ball_.x_m, ball_.y_m);
  ball_.seen_s = best->heard_s;
  ball_.told = true;
}

void WorldModel::field_to_body(float x_m, float y_m, float& ahead_m, float& left_m) const {
  const float dx = x_m - pose_.mean.x_m, dy = y_m - pose_.mean.y_m;
  const float c = std::cos(pose_.mean.theta_rad), s = std::sin(pose_.mean.theta_rad);
  ahead_m = c * dx + s * dy;
  left_m = -s * dx + c * dy;
}

float WorldModel::bearing_to(float x_m, float y_m) const {
  float ahead = 0, left = 0;
  field_to_body(x_m, y_m, ahead, left);
  return std::atan2(left, ahead);
}

float WorldModel::distance_to(float x_m, float y_m) const {
  const float dx = x_m - pose_.mean.x_m, dy = y_m - pose_.mean.y_m;
  return std::sqrt(dx * dx + dy * dy);
}

bool WorldModel::is_nearest_to_ball() const {
  const float own = ball_.distance_m();
  for (const Mate& mate : mates_) {
    if (!mate.message.sees_ball || time_s_ - mate.heard_s > kMateMemory_s || mate.message.player == 0) continue;
    // The lower number goes when both are as near, so that exactly one does.
    const float margin = mate.message.player < player_ ? 0.05f : -0.05f;
    if (mate.message.ball_distance_m < own + margin) return false;
  }
  return true;
}

TeamMessage WorldModel::message() const {
  TeamMessage message{.player = player_, .pose = pose_.mean, .sees_ball = ball_age_s() < 0.5f && !ball_.told};
  const float c = std::cos(pose_.mean.theta_rad), s = std::sin(pose_.mean.theta_rad);
  message.ball_x_m = pose_.mean.x_m + c * ball_.x_m - s * ball_.y_m;
  message.ball_y_m = pose_.mean.y_m + s * ball_.x_m + c * ball_.y_m;
  message.ball_distance_m = ball_.distance_m();
  return message;
}

}  // namespace seam::sdk
