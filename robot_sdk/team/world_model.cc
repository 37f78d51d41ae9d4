#include "robot_sdk/team/world_model.h"

#include <algorithm>
#include <cmath>

namespace seam::sdk {
namespace {

constexpr float kMateMemory_s = 2.0f;
constexpr float kHalfPi = 1.57079633f;
constexpr float kHalfLength_m = 2.1f, kHalfWidth_m = 1.35f;
constexpr float kHold_m = 0.149f;     // A held ball's middle before the body's origin.
constexpr float kFastest_mps = 2.0f;  // Of a ball that was kicked.

float length(float x, float y) {
  return std::sqrt(x * x + y * y);
}

// A place in the body frame, after the body has moved by a step.
void move_under(float& x_m, float& y_m, const FieldPose& step) {
  const float c = std::cos(step.theta_rad), s = std::sin(step.theta_rad);
  const float x = x_m - step.x_m, y = y_m - step.y_m;
  x_m = c * x + s * y;
  y_m = -s * x + c * y;
}

}  // namespace

float BallBelief::distance_m() const {
  return length(x_m, y_m);
}
float BallBelief::bearing_rad() const {
  return std::atan2(y_m, x_m);
}

WorldModel::WorldModel(int player, bool attacks_skyblue, uint64_t seed)
    : player_(player),
      attacks_skyblue_(attacks_skyblue),
      filter_({.particles = 400,
               .seed = seed,
               .half_length_m = 2.25f,  // A goalie may stand in its goal.
               .range_outlier_probability = 0.2f,
               .jitter_rad = 0.02f,  // Robots turn each other.
               .slow_rate = 0.02f,
               .fast_rate = 0.1f,
               .blocked_share = 0.2f},
              standard_landmarks()) {
  pose_ = filter_.densest();
}

void WorldModel::update(const Percepts& percepts) {
  time_s_ = percepts.time_s;
  // The ball stays where it is while the body moves under it.
  const FieldPose& step = percepts.odometry_step;
  move_under(ball_.x_m, ball_.y_m, step);
  if (doubted_) move_under(doubted_->x_m, doubted_->y_m, step);
  seen_goal_rad_ -= step.theta_rad;
  for (const LandmarkSighting& sighting : percepts.landmarks) {
    if (sighting.kind !=
        (attacks_skyblue_ ? LandmarkKind::goal_skyblue : LandmarkKind::goal_yellow))
      continue;
    seen_goal_rad_ = sighting.bearing_rad + sighting.free_offset_rad, seen_goal_s_ = time_s_;
  }

  take_situation(percepts.situation);
  filter_.move(step.x_m, step.y_m, step.theta_rad);
  if (!percepts.landmarks.empty()) filter_.observe(percepts.landmarks);
  pose_ = filter_.densest();

  for (const TeamMessage& message : percepts.messages) {
    if (message.player < 0 || message.player >= kTeamSize || message.player == player_) continue;
    mates_[message.player] = {message, time_s_};
  }
  take_ball(percepts);
}

bool WorldModel::stands_wrong() const {
  // Into the other half, or near the middle: then the referee carries the robot back.
  const float into_own = -attack_sign() * pose_.mean.x_m;
  return into_own < 0.05f || length(pose_.mean.x_m, pose_.mean.y_m) < 0.4f;
}

// What the referee does to a robot follows from the rules: at `set` it carries those that stand
// wrong to their places and lays the ball into the middle; who was penalised comes back at the
// half-way line.
void WorldModel::take_situation(const Situation& now) {
  const Situation before = situation_;
  situation_ = now;
  if (now.phase == Situation::set && before.phase != Situation::set) {
    if (home_ && stands_wrong()) filter_.place({*home_}, 0.5f, 0.1f, 0.1f);
    ball_.seen_s = std::min(ball_.seen_s, time_s_ - 2);
    doubted_.reset();
  }
  if (now.phase == Situation::playing && before.phase == Situation::set) {
    played_since_s_ = time_s_;
    if (!home_) home_ = pose_.mean;
  }
  if (before.penalised && !now.penalised) {
    const float x = -0.15f * attack_sign(), y = kHalfWidth_m - 0.2f;
    filter_.place({{x, y, -kHalfPi}, {x, -y, kHalfPi}}, 1, 0.05f, 0.05f);
  }
  if (now.phase == Situation::set && ball_age_s() > 1) {
    field_to_body(0, 0, ball_.x_m, ball_.y_m);
    ball_.seen_s = time_s_, ball_.reported = true, ball_.held = false;
  }
}

bool WorldModel::is_opponents_kick_off() const {
  constexpr float kLongest_s = 10, kAtMiddle_m = 0.3f;
  if (situation_.own_kick_off || played_since_s_ == 0 || time_s_ - played_since_s_ > kLongest_s)
    return false;
  const TeamMessage view = message();
  return length(view.ball_x_m, view.ball_y_m) < kAtMiddle_m;
}

// Nobody plays a ball that lies outside the walls; a robot that knows its place knows what does.
bool WorldModel::could_be_there(const BallSighting& ball) const {
  constexpr float kSure_m = 0.3f;
  if (pose_.spread_xy_m > kSure_m) return true;
  const float direction = pose_.mean.theta_rad + ball.bearing_rad;
  const float slack = 0.35f + 0.15f * ball.distance_m;
  return std::abs(pose_.mean.x_m + ball.distance_m * std::cos(direction)) < kHalfLength_m + slack &&
         std::abs(pose_.mean.y_m + ball.distance_m * std::sin(direction)) < kHalfWidth_m + slack;
}

void WorldModel::take_ball(const Percepts& percepts) {
  const float age = ball_age_s();
  if (percepts.ball && could_be_there(*percepts.ball)) {
    const float distance = percepts.ball->distance_m;
    const BallBelief seen{distance * std::cos(percepts.ball->bearing_rad),
                          distance * std::sin(percepts.ball->bearing_rad), time_s_, false};
    const auto reachable = [&](const BallBelief& from) {
      const float age = time_s_ - from.seen_s;
      return length(seen.x_m - from.x_m, seen.y_m - from.y_m) <
             0.15f + 0.2f * distance + kFastest_mps * age;
    };
    // One frame with the ball elsewhere is not believed, the second is.
    if (age < 1 && !ball_.reported && !reachable(ball_) && !(doubted_ && reachable(*doubted_))) {
      doubted_ = seen;
      return;
    }
    // A ball seen a moment ago is smoothed; after a gap or a jump the new sighting stands alone.
    const float trust = age < 0.2f && !ball_.reported && !doubted_ ? 0.6f : 1.0f;
    doubted_.reset();
    ball_ = {ball_.x_m + trust * (seen.x_m - ball_.x_m), ball_.y_m + trust * (seen.y_m - ball_.y_m),
             time_s_, false};
    return;
  }
  if (holds_ball_) {
    ball_ = {kHold_m, 0, time_s_, false, true};
  } else if (ball_.held) {
    // It has been kicked; where it went is to be seen.
    ball_.held = false, ball_.seen_s = time_s_ - 0.5f;
  }
  if (doubted_ && time_s_ - doubted_->seen_s > 0.5f) doubted_.reset();
  if (age > 2.0f) take_mates_ball();
}

void WorldModel::take_mates_ball() {
  // Not seen for a while: believe the team mate that is nearest to it.
  const Mate* best = nullptr;
  for (const Mate& mate : mates_) {
    if (!mate.message.sees_ball || time_s_ - mate.heard_s > 0.5f) continue;
    if (best == nullptr || mate.message.ball_distance_m < best->message.ball_distance_m)
      best = &mate;
  }
  if (best == nullptr) return;
  field_to_body(best->message.ball_x_m, best->message.ball_y_m, ball_.x_m, ball_.y_m);
  ball_.seen_s = best->heard_s;
  ball_.reported = true, ball_.held = false;
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
  return length(dx, dy);
}

float WorldModel::goal_bearing() const {
  return time_s_ - seen_goal_s_ < 0.4f ? seen_goal_rad_
                                       : bearing_to(attack_sign() * kHalfLength_m, 0);
}

float WorldModel::goal_distance() const {
  return distance_to(attack_sign() * kHalfLength_m, 0);
}

bool WorldModel::is_nearest_to_ball() const {
  const float own = ball_.distance_m();
  for (const Mate& mate : mates_) {
    if (!mate.message.sees_ball || time_s_ - mate.heard_s > kMateMemory_s ||
        mate.message.player == 0)
      continue;
    // The lower number goes when both are as near, so that exactly one does.
    const float margin = mate.message.player < player_ ? 0.05f : -0.05f;
    if (mate.message.ball_distance_m < own + margin) return false;
  }
  return true;
}

TeamMessage WorldModel::message() const {
  TeamMessage message{
      .player = player_, .pose = pose_.mean, .sees_ball = ball_age_s() < 0.5f && !ball_.reported};
  const float c = std::cos(pose_.mean.theta_rad), s = std::sin(pose_.mean.theta_rad);
  message.ball_x_m = pose_.mean.x_m + c * ball_.x_m - s * ball_.y_m;
  message.ball_y_m = pose_.mean.y_m + s * ball_.x_m + c * ball_.y_m;
  message.ball_distance_m = ball_.distance_m();
  return message;
}

}  // namespace seam::sdk
