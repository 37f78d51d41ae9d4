// What a player can do: each skill looks at the world model and says what head and body do next.
#pragma once

#include "robot_sdk/team/world_model.h"

namespace seam::sdk {

struct Action {
  HeadAngles head;
  float vx_mps = 0, vy_mps = 0;
  float omega_radps = 0;
  bool kick = false;
  const char* name = "stand";  // Shown in the viewer.
};

// Sweeps the head over the field; turns on the spot when the ball stays unseen.
Action search_ball(const WorldModel& world);
// Walks towards the ball, the head on it, so as to arrive behind it as seen from the goal.
Action approach_ball(const WorldModel& world);
// The ball is at the feet and the goal ahead.
Action kick_ball(const WorldModel& world);
// Goes to a place on the field, facing the ball, glancing at landmarks.
Action hold_place(const WorldModel& world, float x_m, float y_m);

enum class Role { goalie, defender, attacker, supporter };
Role role_of(int player);
// The team's play: the nearest player goes for the ball, the others keep their places.
Action play(const WorldModel& world, Role role);

}  // namespace seam::sdk
