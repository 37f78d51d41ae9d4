// Puts a run's parts together: scenario, models, world, cameras. Live runs, replays, experiments
// and `measure` all come through here, so that the same scenario gives the same bits everywhere.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/camera_renderer.h"
#include "app/scenario_tree.h"
#include "effects/model.h"
#include "scheduler/loop/observer.h"
#include "sim_core/scenario/scenario.h"
#include "sim_core/world/world.h"

namespace seam::app {

struct SimulatorOptions {
  std::vector<std::string> changes;  // "PATH=VALUE": any key of the scenario or of its models.
  std::optional<int64_t> seed;       // Replaces the scenario's.
  std::vector<std::string>
      models;              // "FILE" for all robots or "ROBOT=FILE"; replace the scenario's.
  int render_workers = 0;  // 0: one for each core.
  std::string drawing =
      "auto";               // "analytic", "opengl", or "auto": OpenGL where the scene needs it.
  std::string gl = "auto";  // Where OpenGL comes from; see render::GlDevice.
  render::RendererOptions rendering;
  bool cameras_when_used = false;  // A model that cannot be rendered fails with its first frame.
};

struct Simulator {
  Scenario scenario;                   // With seed and models replaced.
  std::vector<effects::Model> models;  // One a robot: its own values drawn from spreads.
  World world;
  std::unique_ptr<CameraRenderer> renderer;
  scheduler::RunHeader header;          // Its scenario text holds everything, files included.
  std::vector<ScenarioChange> changes;  // Of the scenario's file, as they were asked for.
};

// One a robot: its file's or the ideal one, with the robot's own values drawn from spreads.
std::vector<effects::Model> models_of(const Scenario& scenario);

// The scenario with seed and models replaced. Throws InputError, UsageError for a `--model` that
// names no robot.
Scenario load_scenario(const std::filesystem::path& file, const SimulatorOptions& options);

Simulator make_simulator(Scenario scenario, const SimulatorOptions& options = {});

// From a log's header, to the same bits as the run that was recorded.
Simulator make_simulator(const scheduler::RunHeader& header, const SimulatorOptions& options = {});

}  // namespace seam::app
