// Looks at the ball and logs its measured distance with every frame: with a resting head the
// experiment of section 5.1 of the founding paper. `ball_ranger [--tilt RAD] [--rate DEG_PER_S
// --amplitude DEG] [--walk M_PER_S] [--from S]`: with a rate the head swings from side to side,
// with a speed the robot walks ahead; it looks from the start on, or from a time.
#include <cmath>
#include <cstdlib>
#include <string>

#include "robot_sdk/robot.h"
#include "robot_sdk/team/perception.h"

using namespace seam::sdk;

int main(int argc, char** argv) {
  constexpr double kDegree = 3.14159265358979323846 / 180;
  double tilt_rad = 0, rate_rad_s = 0, amplitude_rad = 10 * kDegree, walk_m_s = 0, from_s = 0;
  for (int i = 1; i + 1 < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--tilt") tilt_rad = std::atof(argv[i + 1]);
    if (option == "--rate") rate_rad_s = std::atof(argv[i + 1]) * kDegree;
    if (option == "--amplitude") amplitude_rad = std::atof(argv[i + 1]) * kDegree;
    if (option == "--walk") walk_m_s = std::atof(argv[i + 1]);
    if (option == "--from") from_s = std::atof(argv[i + 1]);
  }
  Robot robot(argc, argv);
  Perception perception;
  bool looks = from_s <= 0;
  if (looks) robot.request_all_frames();
  robot.on_observation([&](const Observation& seen) {
    if (!looks && seen.time_s() >= from_s) robot.request_all_frames(), looks = true;
    const Percepts percepts = perception.look(seen);
    if (percepts.has_frame && percepts.ball) {
      robot.log_value("distance_m", percepts.ball->distance_m);
      robot.log_value("bearing_rad", percepts.ball->bearing_rad);
      robot.log_value("from_area_m", percepts.ball->from_area_m);
      robot.log_value("from_centre_m", percepts.ball->from_centre_m);
      robot.log_value("from_edge_m", percepts.ball->from_edge_m);
    }
    Head head{.tilt_rad = tilt_rad};
    if (rate_rad_s > 0) {
      // From one end to the other takes 2 * amplitude / rate; it begins in the middle.
      const double sweeps = seen.time_s() * rate_rad_s / (2 * amplitude_rad) + 0.5;
      const bool leftwards = std::fmod(std::floor(sweeps), 2) == 0;
      head.pan_rad = leftwards ? amplitude_rad : -amplitude_rad;
      head.max_speed_rad_s = rate_rad_s;
      robot.log_value("pan_rad", seen.sensors.joints.pan_rad);
    }
    robot.head(head);
    if (walk_m_s != 0) robot.walk({.vx_m_s = walk_m_s});
  });
  return robot.run();
}
