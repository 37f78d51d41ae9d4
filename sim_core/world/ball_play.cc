#include "sim_core/world/ball_play.h"

#include <algorithm>

#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam {
namespace {

// A held ball that is this far from where it is held has been lost, m.
constexpr double kLost = 0.06;

}  // namespace

BallPlay::BallPlay(const Scenario& scenario, RandomStream stream)
    : scenario_(&scenario), stream_(stream), players_(scenario.robots.size()) {}

bool BallPlay::request(size_t robot, Kick kick, SimTime time) {
  if (kick == Kick::none || busy(robot, time)) return false;
  Player& player = players_[robot];
  player.kick = kick;
  player.start = time;
  player.struck = false;
  return true;
}

bool BallPlay::busy(size_t robot, SimTime time) const {
  const Player& player = players_[robot];
  const KickSpec& kick = scenario_->robots[robot].body.kick(player.kick);
  return player.kick != Kick::none && (time - player.start).s() < kick.duration_s;
}

int BallPlay::holder() const {
  for (size_t i = 0; i < players_.size(); ++i) {
    if (players_[i].holding) return static_cast<int>(i);
  }
  return -1;
}

bool BallPlay::ball_in(const Reach& reach, const PlanarBody& body, const PlanarBody& ball) const {
  const double c = maths::cos(body.theta_rad), s = maths::sin(body.theta_rad);
  const double dx = ball.x_m - body.x_m, dy = ball.y_m - body.y_m;
  const double forward = c * dx + s * dy, left = c * dy - s * dx;
  return forward >= reach.min_x_m && forward <= reach.max_x_m && left >= reach.min_y_m &&
         left <= reach.max_y_m;
}

void BallPlay::act(SimTime time, SimDuration step, PhysicsState& state,
                   std::vector<WorldEvent>& events) {
  if (!scenario_->ball.present) return;
  for (size_t i = 0; i < players_.size(); ++i) act_one(i, time, step, state, events);
}

void BallPlay::hit(size_t robot, PhysicsState& state, std::vector<WorldEvent>& events,
                   SimTime time) {
  Player& player = players_[robot];
  const KickSpec& kick = scenario_->robots[robot].body.kick(player.kick);
  const RandomStream noise =
      stream_.child(static_cast<uint64_t>(robot)).child(static_cast<uint64_t>(player.start.ns()));
  const double speed = kick.speed_mps * std::max(0.0, 1 + kick.speed_sigma * normal(noise, 0));
  const double direction = state.robots[robot].theta_rad + kick.direction_rad +
                           kick.direction_sigma_rad * normal(noise, 1);
  state.ball.vx_mps = speed * maths::cos(direction);
  state.ball.vy_mps = speed * maths::sin(direction);
  player.holding = false;
  events.push_back({time, "kick", static_cast<int>(robot), to_string(player.kick)});
}

void BallPlay::act_one(size_t robot, SimTime time, SimDuration step, PhysicsState& state,
                       std::vector<WorldEvent>& events) {
  Player& player = players_[robot];
  const RobotBody& body = scenario_->robots[robot].body;
  const PlanarBody& place = state.robots[robot];
  if (player.kick == Kick::grab || player.kick == Kick::release) {
    const bool grabs =
        player.kick == Kick::grab && holder() < 0 && ball_in(body.grab, place, state.ball);
    if (grabs) events.push_back({time, "grab", static_cast<int>(robot), ""});
    if (player.kick == Kick::release && player.holding)
      events.push_back({time, "release", static_cast<int>(robot), ""});
    player.holding = grabs || (player.holding && player.kick != Kick::release);
    player.kick = Kick::none;
  } else if (player.kick != Kick::none) {
    const KickSpec& kick = body.kick(player.kick);
    const SimTime impact = player.start + SimDuration::from_s(kick.impact_s);
    if (!player.struck && impact < time + step) {
      player.struck = true;
      if (player.holding || ball_in(kick.reach, place, state.ball)) hit(robot, state, events, time);
    }
    if (!busy(robot, time + step)) player.kick = Kick::none;
  }
  if (!player.holding) return;
  // Where the ball is to be at the end of the step: carried along in front of the body.
  const double h = step.s();
  const double theta = place.theta_rad + h * place.omega_radps;
  const double x = place.x_m + h * place.vx_mps + body.hold_x_m * maths::cos(theta);
  const double y = place.y_m + h * place.vy_mps + body.hold_x_m * maths::sin(theta);
  const double dx = x - state.ball.x_m, dy = y - state.ball.y_m;
  if (maths::length(dx, dy) > kLost || !place.solid) {
    player.holding = false;
    events.push_back({time, "ball_lost", static_cast<int>(robot), ""});
    return;
  }
  state.ball.vx_mps = dx / h;
  state.ball.vy_mps = dy / h;
}

void BallPlay::Player::visit(StateVisitor& visitor) {
  visitor.field("kick", kick);
  visitor.field("kick_start", start);
  visitor.field("struck", struck);
  visitor.field("holding", holding);
}

void BallPlay::visit(StateVisitor& visitor) {
  for (Player& player : players_) {
    player.visit(visitor);
    if (static_cast<size_t>(player.kick) >= kKicks)
      throw InputError("snapshot: a kick of an unknown kind");
  }
}

}  // namespace seam
