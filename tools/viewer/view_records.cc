#include "tools/viewer/view_records.h"

#include <algorithm>
#include <cmath>

namespace seam::tools {

using nlohmann::json;

json json_of(const scheduler::SimulationEvent& event) {
  constexpr const char* kKinds[] = {"referee", "radio", "world", "policy", "fault", "debug"};
  return {{"t", event.time.s()},
          {"kind", kKinds[static_cast<int>(event.kind)]},
          {"robot", event.robot},
          {"name", event.name},
          {"detail", event.detail}};
}

json json_of(const scheduler::PrintedLine& line) {
  return {{"t", line.time.s()},
          {"kind", "printed"},
          {"robot", line.robot},
          {"name", "printed"},
          {"detail", line.text}};
}

json json_of(const DebugEntry& entry) {
  const scheduler::DebugItem& item = entry.item;
  json one = {{"t", entry.t}, {"name", item.name}};
  if (entry.frame_index) one["frame"] = *entry.frame_index;
  if (item.kind == scheduler::DebugItem::Kind::value) one["value"] = item.value;
  if (item.kind == scheduler::DebugItem::Kind::text) one["text"] = item.text;
  if (item.kind == scheduler::DebugItem::Kind::drawing) {
    one["in_image"] = item.in_image;
    one["points"] = json::array();
    for (size_t i = 0; i + 1 < item.points.size(); i += 2)
      one["points"].push_back({item.points[i], item.points[i + 1]});
  }
  return one;
}

json json_of(const std::vector<DecisionEntry>& decisions, double from_s, double to_s) {
  json found = json::array();
  auto entry = std::lower_bound(decisions.begin(), decisions.end(), from_s,
                                [](const DecisionEntry& e, double t) { return e.t < t; });
  for (; entry != decisions.end() && entry->t < to_s; ++entry) {
    found.push_back({{"t", entry->t}});
    if (entry->frame_index) found.back()["frame"] = *entry->frame_index;
  }
  return found;
}

json json_of(const RowWindow& row, const Pose& X_WC) {
  const Mat3 R = X_WC.R * glm::transpose(link_to_camera_axes());
  return {{"start_ns", std::to_string(row.start.ns())},
          {"end_ns", std::to_string(row.end.ns())},
          {"x_m", X_WC.p.x},
          {"y_m", X_WC.p.y},
          {"z_m", X_WC.p.z},
          {"yaw_rad", std::atan2(R[0].y, R[0].x)},
          {"pitch_rad", -std::asin(std::clamp(R[0].z, -1.0, 1.0))},
          {"roll_rad", std::atan2(R[1].z, R[2].z)}};
}

}  // namespace seam::tools
