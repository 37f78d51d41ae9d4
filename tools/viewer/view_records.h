// What logs and frames hold, as the viewer's answers give it (docs/reference/viewer_api.md).
#pragma once

#include <nlohmann/json.hpp>

#include "sim_core/base/pose.h"
#include "sim_core/scene/frame.h"
#include "tools/viewer/view_index.h"

namespace seam::tools {

nlohmann::json json_of(const scheduler::SimulationEvent& event);
nlohmann::json json_of(const scheduler::PrintedLine& line);
nlohmann::json json_of(const DebugEntry& entry);
// Those from `from_s` on and before `to_s`.
nlohmann::json json_of(const std::vector<DecisionEntry>& decisions, double from_s, double to_s);
// When a row collects light, and where the camera is in the middle of that.
nlohmann::json json_of(const RowWindow& row, const Pose& X_WC);

}  // namespace seam::tools
