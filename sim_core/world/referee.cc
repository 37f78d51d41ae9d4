#include "sim_core/world/referee.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sim_core/base/maths.h"

namespace seam {
namespace {

constexpr double kThrowIn = 0.3;  // Metres inside the field.
constexpr double kStuckDistance = 0.3;
constexpr double kBesideField = 0.7;  // Metres outside, where penalised robots wait.

Team other(Team team) {
  return team == Team::red ? Team::blue : Team::red;
}
std::string name_of(Team team) {
  return team == Team::red ? "red" : "blue";
}

}  // namespace

std::string to_string(PlayState state) {
  static constexpr std::array<const char*, 5> kNames = {"initial", "ready", "set", "playing",
                                                        "finished"};
  return kNames.at(static_cast<size_t>(state));
}

Referee::Referee(const Scenario& scenario)
    : scenario_(&scenario),
      kick_off_(scenario.referee.kick_off),
      punished_(scenario.robots.size()) {
  if (!scenario.referee.enabled) state_ = PlayState::playing;
}

void Referee::set_state(PlayState state, SimTime time) {
  state_ = state;
  entered_ = stuck_since_ = time;
}

void Referee::enter(PlayState state, const RefereeView& view, RefereeOrders& orders) {
  set_state(state, view.time);
  orders.events.push_back({to_string(state), -1, ""});
  if (state == PlayState::set) line_up(view, orders);
}

// Ball into the middle; robots out of their own half go to their starting places.
void Referee::line_up(const RefereeView& view, RefereeOrders& orders) {
  orders.place_ball = true;
  orders.ball_x_m = orders.ball_y_m = 0;
  stuck_x_m_ = stuck_y_m_ = 0;
  for (size_t i = 0; i < view.robots.size(); ++i) {
    if (punished_[i].penalty != Penalty::none) continue;
    const RobotSpec& robot = scenario_->robots[i];
    const double own_side = robot.team == Team::red ? -1 : 1;
    const double into_own = own_side * view.robots[i].x_m;
    const double from_middle = maths::length(view.robots[i].x_m, view.robots[i].y_m);
    const bool too_near =
        robot.team != kick_off_ && from_middle < 0.5 * scenario_->field.centre_circle_m + 0.2;
    if (into_own < 0 || too_near || from_middle < 0.2)
      orders.robots.push_back({i, robot.pose, true});
  }
}

RefereeOrders Referee::judge(const RefereeView& view) {
  RefereeOrders orders;
  if (scenario_->referee.enabled) {
    run_clock(view, orders);
    if (state_ == PlayState::playing) {
      watch_holding(view, orders);
      watch_ball(view, orders);
    }
    end_penalties(view, orders);
  }
  last_ = view.time;
  return orders;
}

void Referee::run_clock(const RefereeView& view, RefereeOrders& orders) {
  const RefereeSpec& rules = scenario_->referee;
  const SimDuration in_state = view.time - entered_;
  switch (state_) {
    case PlayState::initial:
      enter(PlayState::ready, view, orders);
      break;
    case PlayState::ready:
      if (in_state >= rules.ready) enter(PlayState::set, view, orders);
      break;
    case PlayState::set:
      if (in_state >= rules.set) enter(PlayState::playing, view, orders);
      break;
    case PlayState::playing:
      played_ = played_ + (view.time - last_);
      if (played_ < rules.half) break;
      if (half_ + 1 == rules.halves) {
        enter(PlayState::finished, view, orders);
      } else {
        ++half_;
        played_ = SimDuration();
        kick_off_ = half_ % 2 == 0 ? rules.kick_off : other(rules.kick_off);
        orders.events.push_back({"half_time", -1, fmt::format("{}:{}", score_[0], score_[1])});
        enter(PlayState::ready, view, orders);
      }
      break;
    case PlayState::finished:
      break;
  }
}

void Referee::watch_ball(const RefereeView& view, RefereeOrders& orders) {
  const FieldSpec& field = scenario_->field;
  const double radius = 0.5 * scenario_->ball.diameter_m;
  const double x = view.ball_x_m, y = view.ball_y_m;
  if (std::abs(x) > field.half_length_m + radius && std::abs(y) < 0.5 * field.goal_width_m) {
    const Team team = x > 0 ? Team::red : Team::blue;
    ++score_[static_cast<size_t>(team)];
    orders.events.push_back(
        {"goal", -1, fmt::format("{} {}:{}", name_of(team), score_[0], score_[1])});
    kick_off_ = other(team);
    enter(PlayState::ready, view, orders);
    return;
  }
  const double moved = maths::length(x - stuck_x_m_, y - stuck_y_m_);
  if (moved > kStuckDistance) stuck_x_m_ = x, stuck_y_m_ = y, stuck_since_ = view.time;
  const bool out =
      std::abs(x) > field.half_length_m + radius || std::abs(y) > field.half_width_m + radius;
  const bool stuck = view.time - stuck_since_ > scenario_->referee.stuck;
  if (!out && !stuck) return;
  orders.place_ball = true;
  orders.ball_x_m =
      out ? std::clamp(x, kThrowIn - field.half_length_m, field.half_length_m - kThrowIn) : 0;
  orders.ball_y_m =
      out ? std::clamp(y, kThrowIn - field.half_width_m, field.half_width_m - kThrowIn) : 0;
  stuck_x_m_ = orders.ball_x_m, stuck_y_m_ = orders.ball_y_m, stuck_since_ = view.time;
  orders.events.push_back({out ? "ball_out" : "stuck", -1, ""});
}

void Referee::watch_holding(const RefereeView& view, RefereeOrders& orders) {
  if (view.ball_holder != holder_) holder_ = view.ball_holder, holding_since_ = view.time;
  if (holder_ < 0 || view.time - holding_since_ <= scenario_->referee.holding) return;
  const auto robot = static_cast<size_t>(holder_);
  punished_[robot] = {Penalty::ball_holding, view.time + scenario_->referee.penalty};
  const double x = scenario_->robots[robot].team == Team::red ? -0.5 : 0.5;
  const double y =
      -(scenario_->field.half_width_m + kBesideField) - 0.3 * static_cast<double>(robot / 2);
  orders.robots.push_back({robot, {x, y, 1.5707963267948966}, false});
  orders.events.push_back({"penalty", static_cast<int>(robot), "ball holding"});
  holder_ = -1;
}

void Referee::end_penalties(const RefereeView& view, RefereeOrders& orders) {
  for (size_t i = 0; i < punished_.size(); ++i) {
    if (punished_[i].penalty == Penalty::none || view.time < punished_[i].until) continue;
    punished_[i].penalty = Penalty::none;
    // At the half-way line, on the side away from the ball, facing the field.
    const double side = view.ball_y_m > 0 ? -1 : 1;
    const double x = scenario_->robots[i].team == Team::red ? -0.15 : 0.15;
    orders.robots.push_back(
        {i, {x, side * (scenario_->field.half_width_m - 0.2), -side * 1.5707963267948966}, true});
    orders.events.push_back({"penalty_over", static_cast<int>(i), ""});
  }
}

SimDuration Referee::remaining(SimTime time) const {
  if (!scenario_->referee.enabled) return scenario_->duration - (time - SimTime());
  SimDuration played = played_;
  if (state_ == PlayState::playing) played = played + (time - last_);
  return std::max(SimDuration(), scenario_->referee.half - played);
}

GameState Referee::game_state(size_t robot, SimTime time) const {
  const Team team = scenario_->robots[robot].team;
  const Punished& punished = punished_[robot];
  GameState game{.state = state_,
                 .first_half = half_ == 0,
                 .kick_off_team = kick_off_,
                 .own_score = score(team),
                 .opponent_score = score(other(team)),
                 .remaining = remaining(time),
                 .penalty = punished.penalty};
  if (punished.penalty != Penalty::none)
    game.penalty_remaining = std::max(SimDuration(), punished.until - time);
  return game;
}

bool Referee::may_move(size_t robot) const {
  const bool moving_state = state_ == PlayState::ready || state_ == PlayState::playing;
  return moving_state && punished_[robot].penalty == Penalty::none;
}

void Referee::Punished::visit(StateVisitor& visitor) {
  visitor.field("penalty", penalty);
  visitor.field("until", until);
}

void Referee::visit(StateVisitor& visitor) {
  visitor.field("state", state_);
  visitor.field("entered", entered_);
  visitor.field("last", last_);
  visitor.field("half", half_);
  visitor.field("played", played_);
  visitor.field("kick_off", kick_off_);
  visitor.field("red_score", score_[0]);
  visitor.field("blue_score", score_[1]);
  for (Punished& robot : punished_) robot.visit(visitor);
  visitor.field("holder", holder_);
  visitor.field("holding_since", holding_since_);
  visitor.field("stuck_x_m", stuck_x_m_);
  visitor.field("stuck_y_m", stuck_y_m_);
  visitor.field("stuck_since", stuck_since_);
}

}  // namespace seam
