#include "app/session/scenario_frames.h"

#include <algorithm>

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

}  // namespace

void visit_scenario_frames(
    const std::string& scenario_file, const SimulatorOptions& options, const std::string& robot,
    SimTime from, SimTime to,
    const std::function<void(const scheduler::FinishedFrame&, const render::Renderer&)>& visit) {
  Scenario scenario = load_scenario(scenario_file, options);
  const size_t index = robot_of(scenario, robot);
  const SimTime end = SimTime() + scenario.duration;
  if (from > end) {
    throw UsageError(fmt::format(
        "found a time of {} s, expected one up to the scenario's end at {} s", from.s(), end.s()));
  }
  // Long enough for the last rows of the last frame.
  constexpr int64_t kTail_ns = 500'000'000;
  scenario.duration = to - SimTime() + SimDuration::from_ns(kTail_ns);
  const ScratchFolder folder("frames");
  const std::string log_file = (folder.path() / "run.mcap").string();
  {
    const SessionOptions session{.log = log_file};
    SessionOutputs outputs(session);
    Simulator simulator = make_simulator(scenario, options);
    const SessionSummary summary = run_session(simulator, session, outputs);
    if (summary.end == scheduler::EndReason::aborted) {
      throw InputError(
          fmt::format("{}: the run was aborted: {}", scenario_file, summary.abort_reason));
    }
  }
  const scheduler::Log log = scheduler::Log::open(log_file);
  Simulator simulator = make_simulator(std::move(scenario), options);
  scheduler::Rewinder rewinder(log, simulator.world);
  const render::Renderer& camera = simulator.renderer->camera(static_cast<int>(index));
  scheduler::make_frames(rewinder, *simulator.renderer, static_cast<int>(index), from, to,
                         [&](const scheduler::FinishedFrame& frame) { visit(frame, camera); });
}

}  // namespace seam::app
