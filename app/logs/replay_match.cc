#include "app/logs/replay_match.h"

#include <algorithm>

#include "app/simulator.h"
#include "sim_core/base/error.h"

namespace seam::app {

struct ReplayMatch::Impl {
  const scheduler::Log& log;
  ReplayOptions options;
  Simulator simulator;
  std::optional<Simulator> other_cameras;  // Only its renderer is used.
  std::optional<scheduler::Rewinder> rewinder;
};

namespace {

std::string version_of(const scheduler::RunHeader& header, const std::string& name) {
  for (const auto& [key, version] : header.versions) {
    if (key == name) return version;
  }
  return "";
}

void check_state_version(const scheduler::Log& log) {
  const std::string version = version_of(log.header(), "state");
  if (version.empty() || version == scheduler::kStateVersion) return;
  throw InputError(fmt::format(
      "{}: recorded by seam {} with states of version {}, this program has version {}: it can be "
      "shown, exported and recovered, but not re-run",
      log.name(), version_of(log.header(), "seam"), version, scheduler::kStateVersion));
}

}  // namespace

ReplayMatch::ReplayMatch(const scheduler::Log& log, const ReplayOptions& options) {
  check_state_version(log);
  SimulatorOptions simulator_options;
  simulator_options.render_workers = options.render_threads;
  impl_.reset(new Impl{log, options, make_simulator(log.header(), simulator_options), {}, {}});
  // Other models and renderers change what cameras see, never what happened.
  if (!options.models.empty() || options.drawing != "auto" || options.gl != "auto") {
    simulator_options.models = options.models;
    simulator_options.drawing = options.drawing, simulator_options.gl = options.gl;
    impl_->other_cameras = make_simulator(log.header(), simulator_options);
  }
}
ReplayMatch::~ReplayMatch() = default;

const Scenario& ReplayMatch::scenario() const {
  return impl_->simulator.scenario;
}
World& ReplayMatch::world() {
  return impl_->simulator.world;
}

CameraRenderer& ReplayMatch::renderer() {
  return impl_->other_cameras ? *impl_->other_cameras->renderer : *impl_->simulator.renderer;
}

std::string ReplayMatch::why_other_pixels() const {
  for (const char* name : {"opengl", "opengl_renderer"}) {
    const std::string recorded = version_of(impl_->log.header(), name);
    const std::string here = version_of(impl_->simulator.header, name);
    if (!recorded.empty() && recorded != here)
      return fmt::format("frames: drawn by {}, here is {}", recorded, here);
  }
  return "";
}

const scheduler::RunHeader& ReplayMatch::header() const {
  return impl_->simulator.header;
}

scheduler::Rewinder& ReplayMatch::rewinder() {
  if (!impl_->rewinder) impl_->rewinder.emplace(impl_->log, impl_->simulator.world);
  return *impl_->rewinder;
}

int ReplayMatch::robot(const std::string& id) const {
  return robot_number(scenario(), id);
}

int robot_number(const Scenario& scenario, const std::string& id) {
  const size_t index = scenario.robot_index(id);
  if (index < scenario.robots.size()) return static_cast<int>(index);
  std::vector<std::string> ids;
  for (const RobotSpec& robot : scenario.robots) ids.push_back(robot.id);
  throw UsageError(fmt::format("--robot: unknown robot '{}'{}", id, suggestion_for(id, ids)));
}

std::string seconds(SimTime time) {
  return fmt::format("{:.6g} s", time.s());
}

}  // namespace seam::app
