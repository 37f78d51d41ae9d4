// What logs and frames hold, as the viewer's answers give it (docs/reference/viewer_api.md).
#pragma once

#include <nlohmann/json.hpp>

#include "sim_core/base/pose.h"
#include "sim_core/scene/frame.h"
#include "tools/viewer/view_index.h"
#include "tools/viewer/view_query.h"

namespace seam::tools {

nlohmann::json json_of(const scheduler::SimulationEvent& event);
nlohmann::json json_of(const scheduler::PrintedLine& line);
// All events and printed lines in the order of time.
std::string events_of(const ViewIndex& index);
// `seam replay find` for the page: seam-find/1 of the condition `when`, without it the names that a
// condition can read. Throws UsageError for a bad condition.
std::string find_answer(const scheduler::Log& log, const Query& query);
// Times of a robot's decisions, frames and logged texts for a strip of `points` marks.
nlohmann::json lanes_of(const RobotIndex& robot, const Query& query, double end_s);
nlohmann::json json_of(const DebugEntry& entry);
// Those from `from_s` on and before `to_s`.
nlohmann::json json_of(const std::vector<DecisionEntry>& decisions, double from_s, double to_s);
// When a row collects light, and where the camera is in the middle of that.
nlohmann::json json_of(const RowWindow& row, const Pose& X_WC);

}  // namespace seam::tools
