#include "robot_sdk/team/skills.h"

#include <algorithm>
#include <cmath>

namespace seam::sdk {
namespace {

constexpr float kWalk_mps = 0.25f;
constexpr float kSidestep_mps = 0.15f;
constexpr float kTurn_radps = 1.5f;
constexpr float kTurnWithBall_radps = 2.0f;
constexpr float kGoalX_m = 2.1f;
constexpr float kGoalHalfWidth_m = 0.3f;
constexpr float kSideways_m = 0.8f;
constexpr float kGoaliesBall_m = 0.9f;
constexpr float kTouch_m = 0.15f;  // From the body's origin to a ball that touches it.
constexpr float kHeadPan_rad = 1.5f;

float clamp(float value, float limit) {
  return std::clamp(value, -limit, limit);
}

float wrap(float angle) {
  constexpr float kTurn = 6.28318531f;
  return angle - kTurn * std::round(angle / kTurn);
}

// The part of a period that has passed, 0 to 1.
float phase_of(float time_s, float period_s) {
  return time_s / period_s - std::floor(time_s / period_s);
}

// From -1 to 1 and back.
float triangle(float time_s, float period_s) {
  const float phase = phase_of(time_s, period_s);
  return phase < 0.5f ? 4 * phase - 1 : 3 - 4 * phase;
}

// Looks left and right over one and a half seconds each way, level and low in turn.
HeadAngles sweep(float time_s) {
  const bool low = phase_of(time_s, 6) >= 0.5f;
  return {low ? -0.45f : -0.10f, 1.3f * triangle(time_s, 3), 0};
}

// At the landmark that is nearest to a bearing, of those that the head can turn to.
HeadAngles look_at_landmark(const WorldModel& world, float near_rad) {
  static const std::vector<LandmarkPosition> kLandmarks = standard_landmarks();
  float best_rad = 0, least = 1e6f;
  for (const LandmarkPosition& landmark : kLandmarks) {
    const float bearing = world.bearing_to(landmark.x_m, landmark.y_m);
    const float way = std::abs(wrap(bearing - near_rad));
    if (std::abs(bearing) < kHeadPan_rad && world.distance_to(landmark.x_m, landmark.y_m) > 0.5f &&
        way < least) {
      least = way, best_rad = bearing;
    }
  }
  return {-0.05f, best_rad, 0};
}

HeadAngles look_at_ball(const WorldModel& world) {
  const BallBelief& ball = world.ball();
  const float down = std::atan2(0.19f - kBallRadius_m, std::max(ball.distance_m() - 0.12f, 0.05f));
  // Not where it should be: to both sides of it.
  const float aside = world.ball_age_s() > 0.6f ? 0.7f * triangle(world.time_s(), 1.2f) : 0;
  return {-std::min(down, 1.2f), clamp(ball.bearing_rad() + aside, kHeadPan_rad), 0};
}

// Mostly on the ball, and at landmarks in between: who never looks up is lost. At the ball the
// glance is short.
HeadAngles watch_ball(const WorldModel& world) {
  constexpr float kPeriod_s = 2.0f, kClose_m = 0.4f, kAtFeet_m = 0.24f;
  const float distance = world.ball().distance_m();
  const float looks_until = distance < kClose_m ? 0.8f : 0.65f;
  if (phase_of(world.time_s(), kPeriod_s) < looks_until || distance < kAtFeet_m)
    return look_at_ball(world);
  // To one side of the ball and to the other in turn.
  const float aside = phase_of(world.time_s(), 2 * kPeriod_s) < 0.5f ? 0.7f : -0.7f;
  return look_at_landmark(world, clamp(world.ball().bearing_rad() + aside, 1.2f));
}

void walk_to(Action& action, float ahead_m, float left_m, float slow_within_m) {
  const float distance = std::sqrt(ahead_m * ahead_m + left_m * left_m);
  const float bearing = std::atan2(left_m, ahead_m);
  const float speed = kWalk_mps * std::min(1.0f, distance / slow_within_m);
  action.vx_mps = speed * std::max(0.0f, std::cos(bearing));
  action.vy_mps = clamp(speed * std::sin(bearing), kSidestep_mps);
  action.omega_radps = clamp(2 * bearing, kTurn_radps);
}

// Where a grab takes the ball, with some slack to the body's own reach.
bool can_grab(const WorldModel& world) {
  const BallBelief& ball = world.ball();
  const bool seen = !ball.reported && !ball.held && world.ball_age_s() < 0.2f;
  return seen && ball.x_m > 0.11f && ball.x_m < 0.18f && std::abs(ball.y_m) < 0.05f;
}

// How far from where the goal is free a kick may point: the rest of the half width is for the
// kick's own spread.
float aim_within(const WorldModel& world) {
  return 0.3f * kGoalHalfWidth_m / std::max(world.goal_distance(), 0.4f);
}

}  // namespace

Action search_ball(const WorldModel& world) {
  Action action{.head = sweep(world.time_s()), .name = "search"};
  // All the way round: where the ball was believed to be, it is not.
  if (world.ball_age_s() > 3) action.omega_radps = world.player() % 2 == 0 ? 0.8f : -0.8f;
  return action;
}

Action look_around(const WorldModel& world) {
  return {.head = sweep(world.time_s()), .name = "look"};
}

Action approach_ball(const WorldModel& world) {
  const BallBelief& ball = world.ball();
  Action action{.head = watch_ball(world), .name = "approach"};
  const float ahead_m = ball.distance_m() - kTouch_m;
  // From afar towards a place behind the ball, so as to arrive with the goal ahead; the nearer, the
  // more at the ball.
  const float goal_x = world.goal_distance() * std::cos(world.goal_bearing()) - ball.x_m;
  const float goal_y = world.goal_distance() * std::sin(world.goal_bearing()) - ball.y_m;
  const float far = std::max(std::sqrt(goal_x * goal_x + goal_y * goal_y), 0.1f);
  const float behind_m = std::clamp(0.5f * (ball.distance_m() - 0.35f), 0.0f, 0.3f);
  const float bearing =
      std::atan2(ball.y_m - behind_m * goal_y / far, ball.x_m - behind_m * goal_x / far);
  // Turn first towards a ball at the side; near by come slowly, so that it is not pushed away.
  action.omega_radps = clamp(2.5f * bearing, kTurn_radps);
  action.vx_mps = std::clamp(0.06f + 0.8f * ahead_m, 0.0f, kWalk_mps) *
                  std::max(0.0f, std::cos(1.5f * bearing));
  if (behind_m == 0) action.vy_mps = clamp(1.5f * ball.y_m, 0.5f * kSidestep_mps);
  // Too close to turn: a step back.
  if (ahead_m < 0.06f && std::abs(bearing) > 0.5f) action.vx_mps = -0.08f;
  return action;
}

Action turn_with_ball(const WorldModel& world, float goal) {
  Action action{
      .head = look_at_landmark(world, clamp(goal, 1.2f)), .holds_ball = true, .name = "turn"};
  action.omega_radps = clamp(4 * goal, kTurnWithBall_radps);
  // Away from what may be in the way of the turn: the ball is mostly grabbed where it is contested.
  if (std::abs(goal) > 0.8f) action.vx_mps = -0.08f;
  return action;
}

Action hold_place(const WorldModel& world, float x_m, float y_m) {
  Action action{.head = world.ball_age_s() < 1 ? watch_ball(world) : sweep(world.time_s()),
                .name = "hold"};
  const float distance = world.distance_to(x_m, y_m);
  if (distance > 0.15f) {
    const float bearing = world.bearing_to(x_m, y_m);
    walk_to(action, distance * std::cos(bearing), distance * std::sin(bearing), 0.4f);
  } else {
    // Without a ball to face: to the one side of the other half and to the other, so that nothing
    // before the own goal stays unseen for long.
    const float side_m = phase_of(world.time_s(), 6) < 0.5f ? kSideways_m : -kSideways_m;
    const float face = world.ball_age_s() < 2
                           ? world.ball().bearing_rad()
                           : world.bearing_to(x_m + 0.5f * world.attack_sign(), y_m + side_m);
    if (std::abs(face) > 0.2f) action.omega_radps = clamp(face, 0.8f);
  }
  return action;
}

Role role_of(int player) {
  static constexpr Role kRoles[kTeamSize] = {Role::goalie, Role::defender, Role::attacker,
                                             Role::supporter};
  return kRoles[std::clamp(player, 0, kTeamSize - 1)];
}

Action Player::play_held_ball(const WorldModel& world) {
  // The rules allow three seconds; the kick itself takes a quarter of one.
  constexpr float kFirstLook_s = 0.3f, kLongest_s = 2.4f, kPatience_radps = 0.03f;
  const float held_s = world.time_s() - grabbed_s_;
  const float goal = world.goal_bearing();
  Action action = turn_with_ball(world, goal);
  if (held_s < kFirstLook_s) {
    // Is it really there?
    action.head = look_at_ball(world);
    action.holds_ball = false;
    return action;
  }
  const bool aimed = std::abs(goal) < aim_within(world) + kPatience_radps * held_s;
  if (aimed || held_s > kLongest_s) {
    // Never towards the own goal.
    action.kick = std::abs(goal) < 1.3f ? Kick::leg_forward : Kick::release;
    action.holds_ball = false;
    action.name = "kick";
    holds_ = false;
  }
  return action;
}

Action Player::keep_place(const WorldModel& world) const {
  const float sign = world.attack_sign();
  const bool knows_ball = world.ball_age_s() < 2;
  switch (role_) {
    case Role::goalie: {
      // On the line between ball and goal, 25 cm before the goal's middle.
      const float y = knows_ball ? clamp(world.message().ball_y_m * 0.3f, 0.25f) : 0;
      return hold_place(world, -sign * (kGoalX_m - 0.25f), y);
    }
    // The goalie covers the middle; what comes back from the walls comes along the side.
    case Role::defender:
      return hold_place(world, -sign * 1.1f, 0.5f);
    // Near the goal for what bounces back from it. At the other team's kick-off nobody crosses into
    // its half.
    case Role::attacker:
      return hold_place(world, world.is_opponents_kick_off() ? -sign * 0.5f : sign * 1.1f, -0.45f);
    default:
      return hold_place(world, world.is_opponents_kick_off() ? -sign * 0.4f : sign * 0.5f, 0.5f);
  }
}

Action Player::play(const WorldModel& world) {
  constexpr float kSearchAfter_s = 3;
  const BallBelief& ball = world.ball();
  const bool knows_ball = world.ball_age_s() < 2;
  if (holds_) {
    // Seen elsewhere: the grab failed, or somebody took the ball.
    const bool lost =
        world.ball_age_s() < 0.1f && (ball.distance_m() > 0.22f || std::abs(ball.y_m) > 0.09f);
    if (!lost) return play_held_ball(world);
    holds_ = false;
  }
  if (knows_ball && can_grab(world) && !world.is_opponents_kick_off()) {
    // Already behind it: no time is lost by holding it.
    if (std::abs(world.goal_bearing()) < aim_within(world)) {
      return {
          .head = look_at_ball(world), .vx_mps = 0.1f, .kick = Kick::leg_forward, .name = "kick"};
    }
    holds_ = true, grabbed_s_ = world.time_s();
    return {.head = look_at_ball(world), .kick = Kick::grab, .name = "grab"};
  }
  if (role_ == Role::goalie)
    return knows_ball && ball.distance_m() < kGoaliesBall_m ? approach_ball(world)
                                                            : keep_place(world);
  if (world.is_opponents_kick_off()) return keep_place(world);
  if (knows_ball && world.is_nearest_to_ball()) return approach_ball(world);
  // The goalie watches from its place; the others turn until somebody sees the ball.
  return world.ball_age_s() > kSearchAfter_s ? search_ball(world) : keep_place(world);
}

}  // namespace seam::sdk
