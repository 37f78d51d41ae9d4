// `open_r STICK [--design ERS-210]`: runs the OPEN-R objects of a memory stick as a behaviour. A
// scenario names it: behaviour: {command: [open_r, STICK], clock: {period_s: 0.008}}.
#include <cstdio>
#include <string>

#include "open_r/host/program.h"
#include "robot_sdk/robot.h"

namespace {

int drive(seam::open_r::Program& program, int argc, char** argv) {
  seam::sdk::Robot robot(argc, argv);
  bool asked = false;
  robot.on_observation([&](const seam::sdk::Observation& seen) {
    const seam::open_r::TurnOrders orders = program.turn(seen);
    if (!asked && program.wants_images()) robot.request_all_frames();
    asked = true;
    if (!orders.joints.targets.empty()) robot.joints(orders.joints.targets);
    if (orders.joints.walk) robot.walk(*orders.joints.walk);
    for (const auto& [name, value] : orders.values) robot.log_value(name, value);
    for (const std::string& warning : orders.warnings) std::printf("%s\n", warning.c_str());
  });
  const int code = robot.run();
  program.end();
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  // Lines reach `seam run` when they are printed.
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
  std::string stick, design = "ERS-210";
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option.starts_with("--") && i + 1 < argc) {
      if (option == "--design") design = argv[i + 1];
      ++i;  // The SDK reads the rest.
    } else {
      stick = option;
    }
  }
  if (stick.empty()) {
    std::fprintf(stderr, "open_r: expected the folder of a memory stick: open_r STICK\n");
    return 2;
  }
  try {
    seam::open_r::Program program(stick, design);
    return drive(program, argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "open_r: %s\n", error.what());
    return 1;
  }
}
