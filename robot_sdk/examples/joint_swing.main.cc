// Swings one joint of any robot, by its name, from side to side at a constant rate and asks for
// every frame: `joint_swing --joint NAME [--rate DEG_PER_S] [--amplitude DEG] [--no-frames]`.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>

#include "robot_sdk/robot.h"

int main(int argc, char** argv) {
  constexpr double kDegree = 3.14159265358979323846 / 180;
  double rate_rad_s = 90 * kDegree, amplitude_rad = 30 * kDegree;
  std::string joint;
  bool frames = true;
  for (int i = 1; i < argc; ++i) {
    const std::string_view option = argv[i];
    if (option == "--no-frames") frames = false;
    if (i + 1 == argc) break;
    if (option == "--joint") joint = argv[i + 1];
    if (option == "--rate") rate_rad_s = std::atof(argv[i + 1]) * kDegree;
    if (option == "--amplitude") amplitude_rad = std::atof(argv[i + 1]) * kDegree;
  }

  seam::sdk::Robot robot(argc, argv);
  if (frames) robot.request_all_frames();
  robot.on_observation([&](const seam::sdk::Observation& seen) {
    const double sweep_s = 2 * amplitude_rad / rate_rad_s;
    const bool back = std::fmod(std::floor(seen.time_s() / sweep_s + 0.5), 2) != 0;
    robot.joints({{.joint = robot.joint(joint),
                   .angle_rad = back ? -amplitude_rad : amplitude_rad,
                   .max_speed_rad_s = rate_rad_s}});
    robot.log_value(joint + "_rad",
                    seen.sensors.joints.angles_rad.at(static_cast<size_t>(robot.joint(joint))));
  });
  try {
    return robot.run();
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "joint_swing: %s\n", error.what());
    return 2;
  }
}
