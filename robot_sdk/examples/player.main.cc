// A player of the example team: sees through its camera alone, localises, talks to its team mates,
// and plays its role. `player [--number 0..3] [--attacks skyblue|yellow] [--seed N]`
#include <cstdlib>
#include <string>

#include "robot_sdk/robot.h"
#include "robot_sdk/team/perception.h"
#include "robot_sdk/team/skills.h"

using namespace seam::sdk;

int main(int argc, char** argv) {
  int number = 0;
  bool attacks_skyblue = true;
  uint64_t seed = 1;
  for (int i = 1; i + 1 < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--number") number = std::atoi(argv[i + 1]);
    if (option == "--attacks") attacks_skyblue = std::string(argv[i + 1]) == "skyblue";
    if (option == "--seed") seed = std::strtoull(argv[i + 1], nullptr, 10);
  }
  Robot robot(argc, argv);
  Perception perception({.check = true});
  WorldModel world(number, attacks_skyblue, seed * 16 + number + (attacks_skyblue ? 8 : 0));
  Player player(role_of(number));
  int64_t spoke_ns = 0;
  std::string doing;

  robot.request_all_frames();
  robot.on_observation([&](const Observation& seen) {
    Percepts percepts = perception.look(seen);
    percepts.situation.own_kick_off = seen.game.kick_off_team == robot.team();
    world.update(percepts);
    Action action = look_around(world);
    const bool may_act = seen.game.penalty == 0;
    if (seen.game.state == Game::playing && may_act) action = player.play(world);
    if (seen.game.state == Game::ready && may_act && world.home()) {
      action = hold_place(world, world.home()->x_m, world.home()->y_m);
    }
    world.hold_ball(action.holds_ball);
    robot.head({.tilt_rad = action.head.tilt_rad, .pan_rad = action.head.pan_rad});
    robot.walk({action.vx_mps, action.vy_mps, action.omega_radps});
    if (action.kick != Kick::none) robot.kick(action.kick);
    if (doing != action.name) robot.log_text("skill", doing = action.name);
    if (seen.time_ns - spoke_ns > 200'000'000) {
      spoke_ns = seen.time_ns;
      robot.send(encode(world.message()));
      const FieldPose& pose = world.pose().mean;
      robot.log_value("x_m", pose.x_m);
      robot.log_value("y_m", pose.y_m);
      robot.log_value("theta_rad", pose.theta_rad);
    }
    if (percepts.ball) {
      robot.log_value("ball_distance_m", percepts.ball->distance_m);
      robot.log_value("ball_bearing_rad", percepts.ball->bearing_rad);
    }
  });
  return robot.run();
}
