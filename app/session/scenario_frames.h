// Frames of any robot's camera at any time of a scenario: the scenario is run with its behaviours,
// then frames are made from its log, also those that no behaviour asked for.
#pragma once

#include <functional>
#include <string>

#include "app/simulator.h"
#include "scheduler/loop/frame_pipeline.h"

namespace seam::app {

// `visit` gets each frame of the robot's camera clock whose stamp is in [from, to], in order, and
// the camera that made it. Throws UsageError for an unknown robot or times beyond the scenario's
// end; InputError where the run fails.
void visit_scenario_frames(
    const std::string& scenario_file, const SimulatorOptions& options, const std::string& robot,
    SimTime from, SimTime to,
    const std::function<void(const scheduler::FinishedFrame&, const render::Renderer&)>& visit);

// The same for one frame, the first of the robot's camera clock whose stamp is not before `from`.
void visit_first_frame(
    const std::string& scenario_file, const SimulatorOptions& options, const std::string& robot,
    SimTime from,
    const std::function<void(const scheduler::FinishedFrame&, const render::Renderer&)>& visit);

}  // namespace seam::app
