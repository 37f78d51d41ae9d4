#include "robot_sdk/team/skills.h"

#include <algorithm>
#include <cmath>

namespace seam::sdk {
namespace {

constexpr float kWalk_mps = 0.18f;
constexpr float kTurn_radps = 1.2f;
constexpr float kGoalX_m = 2.1f;
constexpr float kKickReach_m = 0.21f;

float clamp(float value, float limit) { return std::clamp(value, -limit, limit); }

// Looks left and right over one and a half seconds each way, level and low in turn.
HeadAngles sweep(float time_s) {
  const float phase = time_s / 3.0f - std::floor(time_s / 3.0f);
  const float triangle = phase < 0.5f ? 4 * phase - 1 : 3 - 4 * phase;
  const bool low = static_cast<int>(std::floor(time_s / 3.0f)) % 2 == 1;
  return {low ? -0.45f : -0.10f, 1.3f * triangle, 0};
}

// On the ball, but one second in four at the landmarks: who never looks up is lost.
HeadAngles watch_ball(const WorldModel& world) {
  if (world.time_s() - 4 * std::floor(world.time_s() / 4) > 3.0f && world.ball().distance_m() > 0.5f) {
    return sweep(1.5f * world.time_s());
  }
  const BallBelief& ball = world.ball();
  const float down = std::atan2(0.19f - kBallRadius_m, std::max(ball.distance_m() - 0.12f, 0.05f));
  return {-std::min(down, 1.2f), clamp(ball.bearing_rad(), 1.5f), 0};
}

void walk_to(Action& action, float ahead_m, float left_m, float slow_within_m) {
  const float distance = std::sqrt(ahead_m * ahead_m + left_m * left_m);
  const float bearing = std::atan2(left_m, ahead_m);
  const float speed = kWalk_mps * std::min(1.0f, distance / slow_within_m);
  // Forward is fast, so turn towards a far place first.
  const float facing = std::max(0.0f, std::cos(bearing));
  action.vx_mps = speed * facing;
  action.vy_mps = clamp(0.5f * left_m, 0.5f * speed);
  action.omega_radps = clamp(1.5f * bearing, kTurn_radps);
}

}  // namespace

Action search_ball(const WorldModel& world) {
  Action action{.head = sweep(world.time_s()), .name = "search"};
  if (world.ball_age_s() > 3) action.omega_radps = world.ball().y_m >= 0 ? 0.6f : -0.6f;
  return action;
}

Action approach_ball(const WorldModel& world) {
  const BallBelief& ball = world.ball();
  Action action{.head = watch_ball(world), .name = "approach"};
  const float goal = world.bearing_to(world.attack_sign() * kGoalX_m, 0);
  // A place a hand behind the ball on the line from the goal; nearer by, straight at the ball.
  const float behind_m = ball.distance_m() > 0.35f ? 0.18f : 0.10f;
  const float ahead = ball.x_m - behind_m * std::cos(goal);
  const float left = ball.y_m - behind_m * std::sin(goal);
  if (ball.distance_m() > 0.35f) {
    walk_to(action, ahead, left, 0.25f);
    return action;
  }
  // Close: circle the ball until the goal is ahead, keeping it in front.
  action.omega_radps = clamp(1.5f * ball.bearing_rad(), kTurn_radps);
  action.vx_mps = clamp(0.8f * (ball.x_m - 0.5f * kKickReach_m), 0.12f);
  action.vy_mps = std::abs(goal) > 0.35f ? (goal > 0 ? -0.10f : 0.10f) : clamp(ball.y_m, 0.08f);
  return action;
}

Action kick_ball(const WorldModel& world) {
  Action action{.head = watch_ball(world), .name = "kick"};
  action.vx_mps = 0.10f;
  action.kick = true;
  return action;
}

Action hold_place(const WorldModel& world, float x_m, float y_m) {
  Action action{.head = world.ball_age_s() < 1 ? watch_ball(world) : sweep(world.time_s()), .name = "hold"};
  const float distance = world.distance_to(x_m, y_m);
  if (distance > 0.15f) {
    const float bearing = world.bearing_to(x_m, y_m);
    walk_to(action, distance * std::cos(bearing), distance * std::sin(bearing), 0.4f);
  } else {
    const float face = world.ball_age_s() < 2 ? world.ball().bearing_rad()
                                              : world.bearing_to(world.attack_sign() * kGoalX_m, 0);
    if (std::abs(face) > 0.2f) action.omega_radps = clamp(face, 0.8f);
  }
  return action;
}

Role role_of(int player) {
  static constexpr Role kRoles[kTeamSize] = {Role::goalie, Role::defender, Role::attacker, Role::supporter};
  return kRoles[std::clamp(player, 0, kTeamSize - 1)];
}

Action play(const WorldModel& world, Role role) {
  const float sign = world.attack_sign();
  const BallBelief& ball = world.ball();
  const bool knows_ball = world.ball_age_s() < 2;
  if (knows_ball && ball.distance_m() < kKickReach_m && std::abs(ball.bearing_rad()) < 0.35f && !ball.told) {
    const float goal = world.bearing_to(sign * kGoalX_m, 0);
    // A goalie clears whatever lies before it, unless towards its own goal.
    if (std::abs(goal) < (role == Role::goalie ? 1.2f : 0.6f)) return kick_ball(world);
  }
  if (role == Role::goalie) {
    if (knows_ball && ball.distance_m() < 0.6f) return approach_ball(world);
    // On the line between ball and goal, 25 cm before the goal's middle.
    const float y = knows_ball ? clamp(world.message().ball_y_m * 0.3f, 0.25f) : 0;
    return hold_place(world, -sign * (kGoalX_m - 0.25f), y);
  }
  if (knows_ball && world.is_nearest_to_ball()) return approach_ball(world);
  if (!knows_ball && role == Role::attacker) return search_ball(world);
  switch (role) {
    case Role::defender: return hold_place(world, -sign * 1.0f, 0.2f);
    case Role::attacker: return hold_place(world, sign * 0.6f, -0.5f);
    default: return hold_place(world, sign * 0.3f, 0.7f);
  }
}

}  // namespace seam::sdk
