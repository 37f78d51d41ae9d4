// The referee: states of play, goals, the clock, balls out and penalties as simple rules. Names
// follow the RoboCup game controller.
//
// Rules: initial -> ready (robots walk to their places) -> set (ball in the middle; robots stand
// still, and those in the wrong half are put to their starting place) -> playing. A goal, and the
// start of a half, lead to ready; the team that conceded has the kick-off. A ball that leaves the
// field is put back 0.3 m inside of where it left; one that nobody moves by 0.3 m for `stuck_s` is
// put into the middle. Holding the ball for longer than `holding_s` costs a penalty: the robot
// stands off the field for `penalty_s` and comes back at the half-way line. Ends are not changed
// between halves: red attacks the sky-blue goal throughout.
#pragma once

#include <string>
#include <vector>

#include "sim_core/base/time.h"
#include "sim_core/body/state.h"
#include "sim_core/scenario/scenario.h"

namespace seam {

enum class PlayState : uint8_t { initial, ready, set, playing, finished };
enum class Penalty : uint8_t { none, ball_holding, manual };
std::string to_string(PlayState state);

// What the referee says to a robot; own and opponent as seen from its team.
struct GameState {
  PlayState state = PlayState::initial;
  bool first_half = true;
  Team kick_off_team = Team::red;
  int own_score = 0;
  int opponent_score = 0;
  SimDuration remaining;  // Of this half.
  Penalty penalty = Penalty::none;
  SimDuration penalty_remaining;
};

// What the referee sees at the end of each world step.
struct RefereeView {
  SimTime time;
  double ball_x_m = 0;
  double ball_y_m = 0;
  std::vector<Pose2> robots;
  int ball_holder = -1;  // Robot that holds the ball; -1: none.
};

// What the referee wants done before the next step.
struct RefereeOrders {
  struct Placement {
    size_t robot;
    Pose2 pose;
    bool on_field;  // False: a penalised robot beside the field; nothing collides with it.
  };
  std::vector<Placement> robots;
  bool place_ball = false;
  double ball_x_m = 0;
  double ball_y_m = 0;
  struct Event {
    std::string
        kind;  // "ready", "set", "playing", "finished", "goal", "ball_out", "stuck", "penalty", ...
    int robot = -1;
    std::string detail;  // For people: "red 1:0".
  };
  std::vector<Event> events;
};

class Referee {
 public:
  Referee(const Scenario& scenario);

  RefereeOrders judge(const RefereeView& view);
  // The supervisor's word.
  void set_state(PlayState state, SimTime time);

  GameState game_state(size_t robot, SimTime time) const;
  // Whether this robot may walk and kick now.
  bool may_move(size_t robot) const;
  int score(Team team) const { return static_cast<int>(score_[static_cast<size_t>(team)]); }
  PlayState state() const { return state_; }
  void visit(StateVisitor& visitor);

 private:
  struct Punished {
    Penalty penalty = Penalty::none;
    SimTime until;
    void visit(StateVisitor& visitor);
  };
  void enter(PlayState state, const RefereeView& view, RefereeOrders& orders);
  void run_clock(const RefereeView& view, RefereeOrders& orders);
  void watch_ball(const RefereeView& view, RefereeOrders& orders);
  void watch_holding(const RefereeView& view, RefereeOrders& orders);
  void end_penalties(const RefereeView& view, RefereeOrders& orders);
  void line_up(const RefereeView& view, RefereeOrders& orders);
  SimDuration remaining(SimTime time) const;

  const Scenario* scenario_;
  PlayState state_ = PlayState::initial;
  SimTime entered_;     // The current state.
  SimTime last_;        // When `judge` was last called.
  int64_t half_ = 0;    // From 0.
  SimDuration played_;  // Of this half.
  Team kick_off_ = Team::red;
  int64_t score_[2] = {0, 0};
  std::vector<Punished> punished_;
  int64_t holder_ = -1;
  SimTime holding_since_;
  double stuck_x_m_ = 0, stuck_y_m_ = 0;
  SimTime stuck_since_;
};

}  // namespace seam
