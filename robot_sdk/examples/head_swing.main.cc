// Swings the head from side to side at a constant rate and asks for every frame: the motion of the
// founding paper's Fig. 9. `head_swing [--rate DEG_PER_S] [--amplitude DEG] [--joint tilt]
// [--no-frames]`; with `--joint tilt` it nods.
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "robot_sdk/robot.h"

int main(int argc, char** argv) {
  constexpr double kDegree = 3.14159265358979323846 / 180;
  double rate_rad_s = 300 * kDegree, amplitude_rad = 45 * kDegree;
  bool frames = true, nods = false;
  for (int i = 1; i < argc; ++i) {
    const std::string_view option = argv[i];
    if (option == "--no-frames") frames = false;
    if (i + 1 == argc) break;
    if (option == "--rate") rate_rad_s = std::atof(argv[i + 1]) * kDegree;
    if (option == "--joint") nods = std::string_view(argv[i + 1]) == "tilt";
    if (option == "--amplitude") amplitude_rad = std::atof(argv[i + 1]) * kDegree;
  }

  seam::sdk::Robot robot(argc, argv);
  if (frames) robot.request_all_frames();
  robot.on_observation([&](const seam::sdk::Observation& seen) {
    // A triangle wave: from one end to the other takes `sweep_s`.
    const double sweep_s = 2 * amplitude_rad / rate_rad_s;
    const double sweeps = seen.time_s() / sweep_s + 0.5;
    const bool leftwards = std::fmod(std::floor(sweeps), 2) == 0;
    const double target_rad = leftwards ? amplitude_rad : -amplitude_rad;
    robot.head({.tilt_rad = nods ? target_rad : 0,
                .pan_rad = nods ? 0 : target_rad,
                .max_speed_rad_s = rate_rad_s});
  });
  return robot.run();
}
