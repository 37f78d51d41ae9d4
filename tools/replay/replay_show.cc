// `seam replay show F [--at T]`: what a log holds, or the state at a time.
#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "app/logs/replay_match.h"
#include "scheduler/log/printed_line.h"
#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"
#include "sim_core/base/output.h"
#include "sim_core/input/shown_text.h"
#include "tools/command.h"
#include "tools/replay/replay.h"

namespace seam::tools {
namespace {

struct ShowSettings {
  std::string file;
  std::optional<double> at_s;
  std::string robot;               // Empty: all.
  std::vector<std::string> kinds;  // Of events; empty: all but radio.
  double from_s = 0;
  double to_s = 9e9;
  bool all = false;  // However many.
  std::string json;
};

const char* to_text(scheduler::EndReason reason) {
  constexpr const char* kWords[] = {"finished", "stopped", "aborted"};
  return kWords[static_cast<int>(reason)];
}

constexpr std::string_view kPrintedKind = "printed";

const char* to_text(scheduler::EventKind kind) {
  constexpr const char* kWords[] = {"referee", "radio", "world", "policy", "fault", "debug"};
  return kWords[static_cast<int>(kind)];
}

nlohmann::ordered_json summary_of(const scheduler::Log& log) {
  const scheduler::RunHeader& header = log.header();
  nlohmann::ordered_json json = {{"format", "seam-show/1"},
                                 {"scenario", header.scenario_name},
                                 {"seed", header.seed},
                                 {"robots", header.robots},
                                 {"end_s", log.end_time().s()}};
  for (const auto& [name, version] : header.versions) json["versions"][name] = version;
  std::map<std::string, uint64_t> counts;
  scheduler::LogCursor cursor(
      log, {scheduler::Topic::turn, scheduler::Topic::step, scheduler::Topic::snapshot,
            scheduler::Topic::frame, scheduler::Topic::event});
  while (cursor.next()) ++counts[std::string(topic_name(cursor.last_topic()))];
  json["messages"] = counts;
  json["chunks"] = log.file().contents().chunks.size();
  json["bytes"] = log.file().file_bytes();
  json["pictures"] = log.has_pictures();
  const auto end = log.end();
  json["end"] = end ? to_text(end->reason) : "unknown: the log has no end";
  json["fingerprint"] = end ? nlohmann::ordered_json(to_hex(end->fingerprint)) : nullptr;
  json["losses"] = nlohmann::ordered_json::array();
  for (const mcap::Loss& loss : log.file().contents().losses) json["losses"].push_back(loss.what);
  if (const auto& behind = log.file().contents().behind_end) {
    json["losses"].push_back("behind the end of the file stands " + behind->what);
  }
  return json;
}

void print_summary(const nlohmann::ordered_json& json) {
  for (const auto& [key, value] : json.items()) {
    if (key == "format") continue;
    const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    std::printf("%-12s %s\n", shown(key).c_str(), shown(text).c_str());
  }
}

// Whether a section such as "robot/red1" is of this robot.
bool is_of(const std::string& section, const std::string& robot) {
  return robot.empty() || section.ends_with("/" + robot);
}

// `robot` empty: of the whole world.
nlohmann::ordered_json state_at(const scheduler::Log& log, SimTime time, const std::string& robot) {
  app::ReplayMatch match(log);
  if (!robot.empty()) match.robot(robot);  // Known, or an error that names the nearest.
  const SimTime reached = match.rewinder().to(time);
  nlohmann::ordered_json json = {{"format", "seam-state/1"},
                                 {"time_ns", reached.ns()},
                                 {"step", match.rewinder().step()},
                                 {"step_time_ns", match.world().start().ns()}};
  for (const StateSection& section : match.world().sections()) {
    if (!is_of(section.name, robot)) continue;
    nlohmann::ordered_json& fields = json["sections"][section.name];
    fields = nlohmann::ordered_json::array();
    for (const StateSection::Field& field : section.fields) {
      std::visit([&](auto value) { fields.push_back({field.name, value}); }, field.value);
    }
  }
  const auto& robots = match.scenario().robots;
  for (size_t i = 0; i < robots.size(); ++i) {
    if (!robot.empty() && robots[i].id != robot) continue;
    const RobotTruth truth = match.world().robot(i, reached);
    nlohmann::ordered_json& out = json["robots"][robots[i].id];
    out = {{"x_m", truth.pose.x_m}, {"y_m", truth.pose.y_m}, {"heading_rad", truth.pose.theta_rad}};
    const RobotBody& body = robots[i].body;
    if (body.tree.present()) {
      for (size_t j = 0; j < body.joint_count(); ++j)
        out[body.joint_name(j) + "_rad"] = truth.joints_rad[j];
    } else {
      out.update({{"tilt_rad", truth.joints_rad[kTilt]},
                  {"pan_rad", truth.joints_rad[kPan]},
                  {"roll_rad", truth.joints_rad[kRoll]}});
    }
  }
  const Vec3 ball = match.world().ball(reached).p_W;
  json["ball"] = {{"x_m", ball.x}, {"y_m", ball.y}, {"z_m", ball.z}};
  return json;
}

// The fields of a section, a line each. A field that is there more than once is one of a list: it
// is shown with its place there.
void print_section(const std::string& section, const nlohmann::ordered_json& fields) {
  std::map<std::string, int> count, shown;
  for (const auto& field : fields) ++count[field[0].get<std::string>()];
  for (const auto& field : fields) {
    const auto name = field[0].get<std::string>();
    const std::string place = count[name] > 1 ? fmt::format("[{}]", shown[name]++) : "";
    std::printf("  %s %s%s %s\n", section.c_str(), name.c_str(), place.c_str(),
                field[1].dump().c_str());
  }
}

void print_state(const nlohmann::ordered_json& json) {
  std::printf("time %.9g s, step %llu\n", json["time_ns"].get<double>() * 1e-9,
              json["step"].get<unsigned long long>());
  const auto print_numbers = [](const std::string& name, const nlohmann::ordered_json& numbers) {
    std::printf("%s:", shown(name).c_str());
    for (const auto& [key, value] : numbers.items()) {
      std::printf(" %s %.6g", key.c_str(), value.get<double>());
    }
    std::printf("\n");
  };
  print_numbers("ball", json["ball"]);
  for (const auto& [robot, truth] : json["robots"].items()) print_numbers(robot, truth);
  std::printf("all fields:\n");
  for (const auto& [section, fields] : json["sections"].items()) print_section(section, fields);
}

// An event, or a line that a behaviour printed.
struct Happening {
  SimTime time;
  std::string kind, robot, name, detail;
};

std::vector<Happening> happenings(const scheduler::Log& log, const ShowSettings& settings) {
  std::vector<Happening> found;
  const auto keep = [&](Happening one) {
    const bool wanted = settings.kinds.empty()
                            ? one.kind != "radio"
                            : std::ranges::find(settings.kinds, one.kind) != settings.kinds.end();
    if (wanted && (settings.robot.empty() || one.robot == settings.robot) &&
        one.time.s() >= settings.from_s && one.time.s() <= settings.to_s)
      found.push_back(std::move(one));
  };
  scheduler::LogCursor events(log, {scheduler::Topic::event});
  while (const auto record = events.next()) {
    const auto& event = std::get<scheduler::SimulationEvent>(*record);
    keep({event.time, to_text(event.kind), event.robot, event.name, event.detail});
  }
  scheduler::PrintedCursor lines(log);
  while (const auto line = lines.next())
    keep({line->time, std::string(kPrintedKind), line->robot, "", line->text});
  std::ranges::stable_sort(found, {}, &Happening::time);
  return found;
}

// How a run began and how it ended are shown always; what lies between where there is room.
void print_events(const scheduler::Log& log, const ShowSettings& settings) {
  constexpr size_t kMost = 40;
  const std::vector<Happening> found = happenings(log, settings);
  if (found.empty() && !settings.kinds.empty()) std::printf("no events of these kinds\n");
  const bool cut = !settings.all && found.size() > kMost;
  for (size_t i = 0; i < found.size(); ++i) {
    if (cut && i == kMost / 2) {
      std::printf("  ... %zu between: --all, --kind, --robot, --from, --to\n",
                  found.size() - kMost);
      i = found.size() - kMost / 2;
    }
    const Happening& one = found[i];
    std::printf("  %10s  %-8s %-8s %s%s%s\n", app::seconds(one.time).c_str(), one.kind.c_str(),
                shown(one.robot).c_str(), shown(one.name).c_str(),
                one.name.empty() || one.detail.empty() ? "" : " ", shown(one.detail).c_str());
  }
}

void show(const ShowSettings& settings) {
  if (settings.at_s && (settings.all || !settings.kinds.empty()))
    throw UsageError("--at shows the state: --kind and --all are for events");
  OutputFile out(settings.json, {.inputs = {settings.file}});
  const scheduler::Log log = scheduler::Log::open(settings.file);
  if (settings.at_s) {
    if (*settings.at_s < 0) throw UsageError("--at: expected seconds from 0 on");
    const SimTime at = SimTime::from_s(*settings.at_s);
    if (at > log.end_time())
      throw UsageError(
          fmt::format("--at {}: the log ends at {}", *settings.at_s, app::seconds(log.end_time())));
    const nlohmann::ordered_json state = state_at(log, at, settings.robot);
    out.fill(state.dump(2) + "\n");
    print_state(state);
    return;
  }
  const nlohmann::ordered_json summary = summary_of(log);
  out.fill(summary.dump(2) + "\n");
  if (!settings.robot.empty() &&
      std::ranges::find(log.header().robots, settings.robot) == log.header().robots.end())
    throw UsageError("--robot: there is no '" + shown(settings.robot) + "'" +
                     suggestion_for(settings.robot, log.header().robots));
  print_summary(summary);
  print_events(log, settings);
}

}  // namespace

void add_replay_show(app::Command replay) {
  app::Command command = replay.add_subcommand(
      "show", "What a log holds and what happened, or the whole state at a time");
  auto settings = std::make_shared<ShowSettings>();
  command.add_option("F", settings->file, "The log").required();
  command.add_option("--at", settings->at_s, "Simulated seconds: show the state at this time")
      .range(-1e9, 9e9);
  command.add_option("--robot", settings->robot,
                     "Of the state, or of events, this robot's part alone");
  command
      .add_option(
          "--kind", settings->kinds,
          "Of events these kinds alone: referee, radio, world, policy, fault, and `printed`,\n"
          "what behaviours wrote to stdout and stderr. All but radio where not given")
      .one_of({"referee", "radio", "world", "policy", "fault", "printed"});
  command.add_option("--from", settings->from_s, "Simulated seconds: events from this time on");
  command.add_option("--to", settings->to_s, "Events up to this time");
  command.add_flag("--all", settings->all, "All such events, not the first and last 20");
  command.add_option("--json", settings->json, "Write the same to this file");
  command.footer(
      "Example: seam replay show match.mcap --at 12.5\n"
      "Example: seam replay show match.mcap --kind printed --robot red1 --from 10 --to 20");
  command.callback([settings] { show(*settings); });
}

}  // namespace seam::tools
