#include "app/session/scenario_frames.h"

#include <algorithm>
#include <utility>

#include "app/camera_warnings.h"
#include "app/scratch_folder.h"
#include "app/session/run_session.h"
#include "app/session/session_outputs.h"
#include "scheduler/log/log.h"
#include "scheduler/replay/frame_maker.h"
#include "scheduler/replay/rewinder.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

size_t robot_of(const Scenario& scenario, const std::string& robot) {
  const size_t index = scenario.robot_index(robot);
  if (index < scenario.robots.size()) return index;
  std::vector<std::string> ids;
  for (const RobotSpec& spec : scenario.robots) ids.push_back(spec.id);
  throw UsageError(fmt::format("--robot: unknown robot '{}'{}", robot, suggestion_for(robot, ids)));
}

void check_time(const Scenario& scenario, SimTime time) {
  const SimTime end = SimTime() + scenario.duration;
  if (time > end) {
    throw UsageError(fmt::format(
        "found a time of {} s, expected one up to the scenario's end at {} s", time.s(), end.s()));
  }
}

using Visit = std::function<void(const scheduler::FinishedFrame&, const render::Renderer&)>;

void visit_frames(Scenario scenario, const SimulatorOptions& options, size_t robot, SimTime from,
                  SimTime to, const Visit& visit) {
  // Long enough for the last rows of the last frame.
  constexpr int64_t kTail_ns = 500'000'000;
  scenario.duration = to - SimTime() + SimDuration::from_ns(kTail_ns);
  // The run is made for its log: where no behaviour could see frames, none are.
  for (RobotSpec& spec : scenario.robots)
    if (spec.behaviour.command.empty()) spec.camera.every_frame = false;
  Simulator simulator = make_simulator(std::move(scenario), options);
  const std::string beginning = simulator.world.snapshot();
  const ScratchFolder folder("frames");
  const std::string log_file = (folder.path() / "run.mcap").string();
  {
    const SessionOptions session{.log = log_file};
    SessionOutputs outputs(session);
    const SessionSummary summary = run_session(simulator, session, outputs);
    if (summary.end == scheduler::EndReason::aborted)
      throw InputError(fmt::format("{}: the run was aborted: {}", simulator.scenario.name,
                                   summary.abort_reason));
  }
  const scheduler::Log log = scheduler::Log::open(log_file);
  simulator.world.restore(beginning);
  scheduler::Rewinder rewinder(log, simulator.world);
  const render::Renderer& camera = simulator.renderer->camera(static_cast<int>(robot));
  bool is_first = true;
  scheduler::make_frames(rewinder, *simulator.renderer, static_cast<int>(robot), from, to,
                         [&](const scheduler::FinishedFrame& frame) {
                           if (std::exchange(is_first, false))
                             warn_of_frame(simulator, robot, *frame.job);
                           visit(frame, camera);
                         });
}

}  // namespace

void visit_scenario_frames(const std::string& scenario_file, const SimulatorOptions& options,
                           const std::string& robot, SimTime from, SimTime to, const Visit& visit) {
  Scenario scenario = load_scenario(scenario_file, options);
  const size_t index = robot_of(scenario, robot);
  check_time(scenario, from);
  visit_frames(std::move(scenario), options, index, from, to, visit);
}

void visit_first_frame(const std::string& scenario_file, const SimulatorOptions& options,
                       const std::string& robot, SimTime from, const Visit& visit) {
  Scenario scenario = load_scenario(scenario_file, options);
  const size_t index = robot_of(scenario, robot);
  check_time(scenario, from);
  const scheduler::Clock clock = scheduler::camera_clock(scenario, static_cast<int>(index));
  const SimTime stamp = clock.tick(clock.first_at_or_after(from));
  bool made = false;
  visit_frames(std::move(scenario), options, index, stamp, stamp,
               [&](const scheduler::FinishedFrame& frame, const render::Renderer& camera) {
                 made = true;
                 visit(frame, camera);
               });
  if (!made)
    throw InputError(
        fmt::format("{}: found no frame of {} after {} s", scenario_file, robot, from.s()));
}

}  // namespace seam::app
