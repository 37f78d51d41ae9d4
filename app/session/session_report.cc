// What a run says of itself at its end.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/session/run_session.h"
#include "app/session/session_outputs.h"
#include "sim_core/base/hash.h"

namespace seam::app {

namespace {

std::string fingerprint_of(const std::string& text) {
  Hasher hasher;
  hasher.add(std::string_view(text));
  return to_hex(hasher.digest());
}

constexpr const char* kEnds[] = {"finished", "stopped", "aborted"};

void put_identity(nlohmann::ordered_json& json, const SessionIdentity& identity) {
  json["scenario"] = {{"name", identity.scenario}, {"fingerprint", identity.fingerprint}};
  json["seed"] = identity.seed;
  json["changes"] = nlohmann::ordered_json::array();
  for (const ScenarioChange& change : identity.changes)
    json["changes"].push_back({{"path", change.path}, {"value", change.value.text}});
  json["models"] = nlohmann::ordered_json::array();
  for (const SessionIdentity::RobotModel& model : identity.models)
    json["models"].push_back(
        {{"robot", model.robot}, {"name", model.model}, {"fingerprint", model.fingerprint}});
  json["versions"] = nlohmann::ordered_json::object();
  for (const auto& [name, version] : identity.versions) json["versions"][name] = version;
}

// The last value of each name, by robot.
nlohmann::ordered_json json_of(const LoggedSummaries& logged) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const auto& [key, summary] : logged) json[key.first][key.second] = summary.last;
  return json;
}

nlohmann::ordered_json json_of(const SessionSummary& summary) {
  nlohmann::ordered_json json = {{"format", "seam-run/1"}};
  put_identity(json, summary.identity);
  json.update({{"sim_s", summary.sim_s},
               {"wall_s", summary.wall_s},
               {"real_time_factor", summary.real_time_factor()},
               {"frames", summary.frames},
               {"fingerprint", to_hex(summary.fingerprint)},
               {"rendered_remotely", summary.rendered_remotely},
               {"decisions", summary.decisions},
               {"waiting_s", summary.waiting_s},
               {"end", kEnds[static_cast<size_t>(summary.end)]}});
  if (summary.has_score) json["score"] = {{"red", summary.red_score}, {"blue", summary.blue_score}};
  json["refused"] = nlohmann::ordered_json::object();
  for (const auto& [robot, refused] : summary.refused)
    json["refused"][robot] = {
        {"decisions", refused.count}, {"first_s", refused.first.s()}, {"first", refused.why}};
  json["values"] = json_of(summary.logged);
  json["log_bytes"] = summary.log_bytes;
  json["memory"] = nlohmann::ordered_json::array();
  for (const MemorySample& sample : summary.memory)
    json["memory"].push_back({{"sim_s", sample.sim_s}, {"rss_bytes", sample.resident_bytes}});
  return json;
}

// What behaviours call their values may be no UTF-8.
std::string json_text(const SessionSummary& summary) {
  return json_of(summary).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) +
         "\n";
}

}  // namespace

SessionIdentity identity_of(const Simulator& simulator) {
  SessionIdentity identity{.scenario = simulator.header.scenario_name,
                           .fingerprint = fingerprint_of(simulator.header.scenario_text),
                           .changes = simulator.changes,
                           .seed = simulator.scenario.seed,
                           .versions = simulator.header.versions};
  for (size_t i = 0; i < simulator.models.size(); ++i) {
    const effects::Model& model = simulator.models[i];
    identity.models.push_back(
        {simulator.scenario.robots[i].id, model.name(), fingerprint_of(model.to_yaml())});
  }
  return identity;
}

int report(const SessionSummary& summary, SessionOutputs& outputs) {
  std::printf(
      "%s: %.3f simulated seconds in %.3f s, %.2f x real time; %llu frames, %llu decisions\n"
      "%s\n",
      kEnds[static_cast<size_t>(summary.end)], summary.sim_s, summary.wall_s,
      summary.real_time_factor(), static_cast<unsigned long long>(summary.frames),
      static_cast<unsigned long long>(summary.decisions),
      summary.has_fingerprint ? ("fingerprint " + to_hex(summary.fingerprint)).c_str()
                              : "no fingerprint: frames that no client sees were not drawn");
  if (summary.has_score)
    std::printf("score red %d, blue %d\n", summary.red_score, summary.blue_score);
  for (const std::string& line : summary.refused_lines) std::fprintf(stderr, "%s\n", line.c_str());
  if (outputs.json) outputs.json.fill(json_text(summary));
  if (summary.end != scheduler::EndReason::aborted) return 0;
  std::fprintf(stderr, "seam: the run was aborted: %s\n", summary.abort_reason.c_str());
  return 1;
}

}  // namespace seam::app
