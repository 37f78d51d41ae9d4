// Looks at the ball with a resting head and logs its measured distance with every frame: the
// experiment of section 5.1 of the founding paper. `ball_ranger [--tilt RAD]`
#include <cstdlib>
#include <string>

#include "robot_sdk/robot.h"
#include "robot_sdk/team/perception.h"

using namespace seam::sdk;

int main(int argc, char** argv) {
  double tilt_rad = 0;
  for (int i = 1; i + 1 < argc; ++i) {
    if (std::string(argv[i]) == "--tilt") tilt_rad = std::atof(argv[i + 1]);
  }
  Robot robot(argc, argv);
  Perception perception;
  robot.request_all_frames();
  robot.on_observation([&](const Observation& seen) {
    const Percepts percepts = perception.look(seen);
    if (percepts.has_frame && percepts.ball) {
      robot.log_value("distance_m", percepts.ball->distance_m);
      robot.log_value("bearing_rad", percepts.ball->bearing_rad);
      robot.log_value("from_area_m", percepts.ball->from_area_m);
      robot.log_value("from_centre_m", percepts.ball->from_centre_m);
      robot.log_value("from_edge_m", percepts.ball->from_edge_m);
    }
    robot.head({.tilt_rad = tilt_rad});
  });
  return robot.run();
}
