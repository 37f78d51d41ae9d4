// A C++ behaviour that makes one mistake at its third turn: `mistaken_behaviour MISTAKE`, for tests
// of what a user then sees (tests/behaviour_mistakes_test.py) and of debuggers
// (tests/debugging_test.py).
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>

#include "robot_sdk/robot.h"

int main(int argc, char** argv) {
  const std::string mistake = argc > 1 ? argv[1] : "none";
  seam::sdk::Robot robot(argc, argv);
  const std::map<std::string, double> offsets_rad = {{"pan", 0.1}};
  robot.on_observation([&](const seam::sdk::Observation& seen) {
    robot.head({.pan_rad = mistake == "degrees" ? 45.0 : 0.1});
    if (seen.sequence != 3) return;
    if (mistake == "exception") robot.head({.pan_rad = offsets_rad.at("pann")});
    if (mistake == "joint") robot.joints({{.joint = robot.joint("pann")}});
    if (mistake == "number") robot.joints({{.joint = 20, .angle_rad = 0.1}});
    if (mistake == "nan") robot.head({.pan_rad = std::nan("")});
    if (mistake == "loop")
      for (volatile int turns = 0; turns >= 0;) turns = 1;
    if (mistake == "sleep") std::this_thread::sleep_for(std::chrono::minutes(1));
    if (mistake == "exit") std::exit(0);
    if (mistake == "code") std::exit(7);
    if (mistake == "abort") std::abort();
    if (mistake == "signal") std::raise(SIGSEGV);
    if (mistake == "throw") throw 3;  // NOLINT: no exception that anybody catches.
    if (mistake == "flood")
      for (int i = 0; i < 3000; ++i) std::printf("%s\n", std::string(100, 'x').c_str());
    if (mistake == "long") robot.log_text("all", std::string(300'000, 'x'));
  });
  return robot.run();
}
