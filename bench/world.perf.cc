// What the world costs without clients and without frames: steps with their hashes, and the scene
// as one robot's camera sees it at an instant, for 2 to 16 robots.
#include "sim_core/world/world.h"

#include <benchmark/benchmark.h>

#include <string>

namespace seam {
namespace {

// Robots of the match, repeated with other names, walking in circles.
World walking_robots(size_t count) {
  Scenario scenario = Scenario::from_file(SEAM_SOURCE_DIR "/scenarios/match.yaml");
  scenario.referee.enabled = false;
  const std::vector<RobotSpec> eight = scenario.robots;
  scenario.robots.clear();
  for (size_t i = 0; i < count; ++i) {
    RobotSpec robot = eight[i % eight.size()];
    robot.id += "_" + std::to_string(i);
    robot.pose.x_m = -1.6 + 0.45 * static_cast<double>(i % 8);
    robot.pose.y_m = i < 8 ? 0.6 : -0.6;
    scenario.robots.push_back(robot);
  }
  World world(scenario);
  RobotCommand command;
  command.walk = BodyVelocity{0.15, 0, 0.9};
  for (size_t i = 0; i < count; ++i) world.apply(i, command, SimTime());
  return world;
}

// A simulated second: 125 steps and their state hashes. Items are simulated seconds.
void world_second(benchmark::State& state) {
  World world = walking_robots(static_cast<size_t>(state.range(0)));
  for (auto _ : state) {
    for (int i = 0; i < 125; ++i) {
      world.step();
      benchmark::DoNotOptimize(world.digest().section_hashes);
    }
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(world_second)
    ->ArgName("robots")
    ->Arg(2)
    ->Arg(4)
    ->Arg(8)
    ->Arg(16)
    ->Unit(benchmark::kMillisecond);

void world_scene(benchmark::State& state) {
  World world = walking_robots(static_cast<size_t>(state.range(0)));
  world.step();
  size_t viewer = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(world.view_of(viewer, world.start(), Pose{}).figures.data());
    viewer = (viewer + 1) % static_cast<size_t>(state.range(0));
  }
}
BENCHMARK(world_scene)
    ->ArgName("robots")
    ->Arg(2)
    ->Arg(4)
    ->Arg(8)
    ->Arg(16)
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace seam

BENCHMARK_MAIN();
