// Kicks and grabs: short motions of head or legs from the robot's body file. A kick hits a ball
// that lies within its reach at its moment of impact; the speed and direction that it gives are
// drawn with the spread stated there. Paws and head that merely move against the ball push it
// through the physics alone.
#pragma once

#include <vector>

#include "sim_core/base/random.h"
#include "sim_core/body/command.h"
#include "sim_core/body/state.h"
#include "sim_core/scenario/scenario.h"
#include "sim_core/world/physics.h"
#include "sim_core/world/world.h"

namespace seam {

class BallPlay {
 public:
  BallPlay(const Scenario& scenario, RandomStream stream);

  // Starts a kick, a grab or a release at this time; false when the robot is still busy with an
  // earlier kick.
  bool request(size_t robot, Kick kick, SimTime time);
  // Whether the robot stands still for a kick.
  bool busy(size_t robot, SimTime time) const;
  void let_go(size_t robot) { players_[robot].holding = false; }
  int holder() const;  // -1: nobody.

  // Before the physics step [time, time + step]: grabs, hits, and holds the ball.
  void act(SimTime time, SimDuration step, PhysicsState& state, std::vector<WorldEvent>& events);
  void visit(StateVisitor& visitor);

 private:
  struct Player {
    Kick kick = Kick::none;  // Under way, or wanted and not yet begun (grab, release).
    SimTime start;
    bool struck = false;
    bool holding = false;
    void visit(StateVisitor& visitor);
  };
  void act_one(size_t robot, SimTime time, SimDuration step, PhysicsState& state,
               std::vector<WorldEvent>& events);
  void hit(size_t robot, PhysicsState& state, std::vector<WorldEvent>& events, SimTime time);
  bool ball_in(const Reach& reach, const PlanarBody& body, const PlanarBody& ball) const;

  const Scenario* scenario_;
  RandomStream stream_;
  std::vector<Player> players_;
};

}  // namespace seam
