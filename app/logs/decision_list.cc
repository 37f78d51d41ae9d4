#include "app/logs/decision_list.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam::app {
namespace {

using nlohmann::ordered_json;

constexpr const char* kFormat = "seam-decisions/1";

std::string dumped(const ordered_json& json) {
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace

std::string to_json(const DecisionList& list) {
  std::string text = fmt::format("{{\"format\": \"{}\", \"robot\": {}, \"decisions\": [\n", kFormat,
                                 dumped(list.robot));
  const char* separator = "";
  for (const auto& [time, orders] : list.decisions) {
    const ordered_json line = {{"time_ns", time.ns()}, {"orders", orders}};
    text += separator + dumped(line);
    separator = ",\n";
  }
  return text + "\n]}\n";
}

DecisionList decision_list_from(const std::filesystem::path& path) {
  try {
    const ordered_json json = ordered_json::parse(read_file(path));
    const std::string format = json.at("format").get<std::string>();
    if (format != kFormat)
      throw InputError(fmt::format("{}: format: found '{}', expected {}", path.string(),
                                   format.substr(0, 64), kFormat));
    DecisionList list{json.at("robot").get<std::string>(), {}};
    for (const ordered_json& one : json.at("decisions"))
      list.decisions[SimTime::from_ns(one.at("time_ns").get<int64_t>())] =
          one.at("orders").get<NamedTexts>();
    return list;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(
        fmt::format("{}: expected {} as `seam replay feed --write-expected` writes it: {}",
                    path.string(), kFormat, error.what()));
  }
}

std::vector<OtherDecision> other_decisions(const DecisionList& expected,
                                           const DecisionList& found) {
  std::set<SimTime> times;
  for (const DecisionList* list : {&expected, &found})
    for (const auto& [time, orders] : list->decisions) times.insert(time);
  std::vector<OtherDecision> others;
  for (const SimTime time : times) {
    const auto a = expected.decisions.find(time), b = found.decisions.find(time);
    if (a == expected.decisions.end()) {
      others.push_back({time, {{"decision", "", "made"}}});
    } else if (b == found.decisions.end()) {
      others.push_back({time, {{"decision", "made", ""}}});
    } else if (a->second != b->second) {
      others.push_back({time, other_fields(a->second, b->second)});
    }
  }
  return others;
}

}  // namespace seam::app
