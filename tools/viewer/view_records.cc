#include "tools/viewer/view_records.h"

#include <algorithm>
#include <cmath>

#include "app/logs/log_search.h"
#include "app/logs/log_signals.h"
#include "sim_core/base/error.h"

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

std::string events_of(const ViewIndex& index) {
  json events = json::array();
  for (const auto& event : index.events) events.push_back(json_of(event));
  for (const auto& line : index.printed) events.push_back(json_of(line));
  std::stable_sort(events.begin(), events.end(), [](const json& a, const json& b) {
    return a["t"].get<double>() < b["t"].get<double>();
  });
  return json{{"events", std::move(events)}}.dump(-1, ' ', false, json::error_handler_t::replace);
}

namespace {

// Of times in ascending order those within [from, to] that are so far apart, the first of them in.
template <class Entries, class Time>
json spaced(const Entries& entries, double from_s, double to_s, double apart_s, const Time& time) {
  json kept = json::array();
  double next = from_s;
  for (const auto& entry : entries) {
    const double t = time(entry);
    if (t > to_s) break;
    if (t < next) continue;
    kept.push_back(t);
    next = t + apart_s;
  }
  return kept;
}

}  // namespace

json lanes_of(const RobotIndex& robot, const Query& query, double end_s) {
  const double from_s = number_of(query, "from", 0), to_s = number_of(query, "to", end_s);
  const auto points = std::clamp<int64_t>(integer_of(query, "points", 1000), 1, 20000);
  const double apart_s = (to_s - from_s) / static_cast<double>(points);
  std::vector<double> texts;
  for (const DebugEntry& entry : robot.debug)
    if (entry.item.kind == scheduler::DebugItem::Kind::text) texts.push_back(entry.t);
  return {{"decisions", spaced(robot.decisions, from_s, to_s, apart_s,
                               [](const DecisionEntry& entry) { return entry.t; })},
          {"frames", spaced(robot.frames, from_s, to_s, apart_s,
                            [](const scheduler::FrameRecord& frame) { return frame.stamp.s(); })},
          {"texts", spaced(texts, from_s, to_s, apart_s, [](double t) { return t; })}};
}

std::string find_answer(const scheduler::Log& log, const Query& query) {
  constexpr size_t kLongest = 1000;
  constexpr int64_t kMostHits = 5000;
  const std::string when = text_of(query, "when", "");
  if (when.empty())
    return json{{"names", app::signal_names(log)}}.dump(-1, ' ', false,
                                                        json::error_handler_t::replace);
  if (when.size() > kLongest)
    throw UsageError(
        fmt::format("condition: found {} characters, expected {} at most", when.size(), kLongest));
  const auto most =
      static_cast<size_t>(std::clamp<int64_t>(integer_of(query, "most", kMostHits), 1, kMostHits));
  app::LogHits found = app::find_in(log, when, most + 1);
  const bool more = found.hits.size() > most;
  if (more) found.hits.pop_back();
  json answer = json::parse(app::to_json(found, when, -1));
  answer["robot"] = found.robot;
  answer["more"] = more;
  return answer.dump(-1, ' ', false, json::error_handler_t::replace);
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
