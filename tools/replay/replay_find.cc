// `seam replay find LOG --when CONDITION`: when something held in a log.
#include <cstdio>

#include "app/logs/log_search.h"
#include "app/logs/log_signals.h"
#include "app/logs/replay_match.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/input/shown_text.h"
#include "tools/command.h"
#include "tools/replay/replay.h"

namespace seam::tools {
namespace {

struct FindSettings {
  std::string file;
  std::string when;
  bool first = false, all = false, count = false, names = false;
  std::string json;
};

void print_names(const scheduler::Log& log) {
  for (const std::string& name : app::signal_names(log)) std::printf("%s\n", shown(name).c_str());
}

void print_hits(const app::LogHits& found, const FindSettings& settings) {
  for (const app::LogHit& hit : found.hits) {
    const std::string robot = found.robot.empty() ? "" : " --robot " + found.robot;
    const std::string end = hit.until_end_of_log ? "the log's end" : app::seconds(hit.end);
    std::printf("%10s to %-14s (%.6g s)  seam view %s --at %.3f%s\n",
                app::seconds(hit.begin).c_str(), end.c_str(), (hit.end - hit.begin).s(),
                shown(settings.file).c_str(), hit.begin.s(), shown(robot).c_str());
  }
  if (!settings.first || found.hits.empty())
    std::printf("%zu %s\n", found.hits.size(), found.hits.size() == 1 ? "hit" : "hits");
}

void find(const FindSettings& settings) {
  if (settings.first + settings.all + settings.count > 1)
    throw UsageError("--first, --all, --count: expected one of them");
  if (settings.names == !settings.when.empty())
    throw UsageError("expected --when CONDITION, or --names for what a condition can read");
  OutputFile json(settings.json, {.inputs = {settings.file}});
  const scheduler::Log log = scheduler::Log::open(settings.file);
  if (settings.names) return print_names(log);
  const app::LogHits found = app::find_in(log, settings.when, settings.first ? 1 : SIZE_MAX);
  if (json) json.fill(app::to_json(found, settings.when, 2) + "\n");
  if (settings.count) {
    std::printf("%zu\n", found.hits.size());
  } else {
    print_hits(found, settings);
  }
  if (found.hits.empty()) throw ExitCode{1};
}

}  // namespace

void add_replay_find(app::Command replay) {
  app::Command command =
      replay.add_subcommand("find", "When a condition held: over logged values, truth and events");
  auto settings = std::make_shared<FindSettings>();
  command.add_option("F", settings->file, "The log").required();
  command.add_option(
      "--when", settings->when,
      "The condition: an expression in the language of models' formulas (== != < > <= >= && ||,\n"
      "+ - * / ^, abs, sqrt, sin, min, if, ...), and `for 0.5 s` where it must hold so long.\n"
      "It reads, by robot: red1.NAME, what its client logged (it holds until the next value);\n"
      "red1.command.pan_rad, red1.command.vx_m_s; truth.red1.x_m, y_m, heading_rad, JOINT_rad,\n"
      "ball_distance_m; truth.ball.x_m; event.goal and red1.event.kick (1 at that instant);\n"
      "red1.event.printed, decision, frame; time_s; NAME.age_s, the time since NAME's last value");
  command.add_flag("--first", settings->first, "The first hit alone");
  command.add_flag("--all", settings->all, "All hits, as without this");
  command.add_flag("--count", settings->count, "Their number alone");
  command.add_flag("--names", settings->names, "Lists all names that this log has");
  command.add_option("--json", settings->json, "Write the hits as seam-find/1 to this file");
  command.footer(
      "Exit code 0: it held; 1: it never did.\n"
      "Example: seam replay find match.mcap --when 'red1.ball_distance_m.age_s > 1 for 0.5 s'\n"
      "Example: seam replay find match.mcap --when 'red4.event.kick' --first");
  command.callback([settings] { find(*settings); });
}

}  // namespace seam::tools
