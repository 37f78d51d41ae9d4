// What a player can do: each skill looks at the world model and says what head and body do next.
#pragma once

#include "robot_sdk/robot.h"
#include "robot_sdk/team/world_model.h"

namespace seam::sdk {

struct Action {
  HeadAngles head;
  float vx_mps = 0, vy_mps = 0;
  float omega_radps = 0;
  Kick kick = Kick::none;
  bool holds_ball = false;     // The ball is between the legs while this goes on.
  const char* name = "stand";  // Shown in the viewer.
};

// Sweeps the head over the field; turns on the spot when the ball stays unseen.
Action search_ball(const WorldModel& world);
// Walks to the ball, from afar so as to arrive behind it, slowly at the end, the head mostly on it.
Action approach_ball(const WorldModel& world);
// The ball is held: turns until the goal, at this bearing, is ahead, the head up at goal and
// landmarks.
Action turn_with_ball(const WorldModel& world, float goal_bearing_rad);
// Goes to a place on the field, facing the ball, glancing at landmarks.
Action hold_place(const WorldModel& world, float x_m, float y_m);
// The player stands still: looks for ball and landmarks.
Action look_around(const WorldModel& world);

enum class Role { goalie, defender, attacker, supporter };
Role role_of(int player);

// The team's play: the nearest player goes for the ball, grabs it, turns and kicks; the others keep
// their places.
class Player {
 public:
  explicit Player(Role role) : role_(role) {}

  Action play(const WorldModel& world);

 private:
  Action play_held_ball(const WorldModel& world);
  Action keep_place(const WorldModel& world) const;

  Role role_;
  float grabbed_s_ = -1e6f;  // When the ball was last grabbed.
  bool holds_ = false;       // As far as the player knows.
};

}  // namespace seam::sdk
