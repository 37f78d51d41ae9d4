// `seam replay whatif F --robot R --client CMD [--from T]`: the same run with one behaviour
// changed.
#include <cstdio>

#include "app/logs/decision_fields.h"
#include "app/logs/frames_of_log.h"
#include "app/logs/log_difference.h"
#include "app/logs/replay_match.h"
#include "app/scratch_folder.h"
#include "app/session/run_session.h"
#include "app/session/runs_made_here.h"
#include "app/session/session_outputs.h"
#include "app/trust/program_consent.h"
#include "scheduler/replay/player.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/input/shown_text.h"
#include "tools/command.h"
#include "tools/replay/replay.h"

namespace seam::tools {
namespace {

struct WhatifSettings {
  std::string file;
  StandIn stand_in;
  double from_s = 0;
  std::string others = "log";
  bool run_programs = false;
  std::string json;
  app::SessionOptions session;
};

// Who is driven live from --from on, and which processes that needs.
scheduler::MixedSourceOptions set_up(const WhatifSettings& settings, const Scenario& scenario,
                                     int changed, app::SessionOptions& session) {
  scheduler::MixedSourceOptions options{.live_from = SimTime::from_s(settings.from_s)};
  for (size_t i = 0; i < scenario.robots.size(); ++i) {
    const bool is_changed = static_cast<int>(i) == changed;
    if (is_changed || settings.others == "live") options.live_robots.insert(static_cast<int>(i));
    // Whom the log drives needs no process.
    if (!is_changed && settings.others == "log") session.commands[scenario.robots[i].id] = {};
  }
  return options;
}

// When the new program first decides otherwise than the old one did, and what: also before --from,
// where it has no effect.
std::string otherwise_text(const scheduler::Log& log, const WhatifSettings& settings, int changed,
                           const scheduler::MixedReport& mixed) {
  const auto alike = mixed.alike.find(changed);
  const uint64_t count = alike == mixed.alike.end() ? 0 : alike->second;
  const auto found = mixed.first_otherwise.find(changed);
  if (found == mixed.first_otherwise.end())
    return fmt::format("{} decides as in the log, each of {} times\n", settings.stand_in.robot,
                       count);
  const scheduler::MixedReport::Otherwise& other = found->second;
  std::string text = fmt::format(
      "{} first decides otherwise at {}, after {} decisions as in the log{}\n",
      settings.stand_in.robot, app::seconds(other.time), count,
      other.time < SimTime::from_s(settings.from_s) ? "; before --from, without effect" : "");
  for (const app::DecisionField& field :
       app::other_fields(other.logged, other.live, app::JointNames(log.header())))
    text +=
        fmt::format("  {}: {} in the log, {} now\n", field.name,
                    field.a.empty() ? "nothing" : field.a, field.b.empty() ? "nothing" : field.b);
  return shown_lines(text);
}

int what_if(const WhatifSettings& settings) {
  app::SessionOptions session = settings.session;
  // A log that is kept can be verified like any other.
  const auto unseen =
      session.log.empty() ? app::UnseenFrames::never : app::UnseenFrames::when_changed;
  session.inputs = {settings.file};
  settings.stand_in.set_up(session);
  const app::ScratchFolder scratch("whatif");
  if (session.log.empty()) session.log = (scratch.path() / "changed.mcap").string();
  app::SessionOutputs outputs(session);
  OutputFile json(settings.json, {.inputs = {settings.file, session.log}});
  const scheduler::Log log = scheduler::Log::open(settings.file);
  app::Simulator simulator = app::make_simulator(log.header());
  const int changed = app::robot_number(simulator.scenario, settings.stand_in.robot);
  if (SimTime::from_s(settings.from_s) > log.end_time()) {
    throw UsageError(fmt::format("--from {}: the log ends at {}", settings.from_s,
                                 app::seconds(log.end_time())));
  }
  if (settings.others == "live") {
    Scenario others = simulator.scenario;
    others.robots[static_cast<size_t>(changed)].behaviour.command.clear();
    app::require_consent(app::programs_of(others),
                         settings.run_programs || app::RunsMadeHere().holds(simulator));
  }
  const scheduler::MixedSourceOptions options =
      set_up(settings, simulator.scenario, changed, session);
  std::printf("%s is driven by %s from %s on; the others %s\n", settings.stand_in.robot.c_str(),
              settings.stand_in.name().c_str(), app::seconds(options.live_from).c_str(),
              settings.others == "log" ? "do what the log says" : "are live from then on too");
  std::fflush(stdout);
  scheduler::MixedReport mixed;
  session.wrap_renderer = [&](scheduler::FrameRenderer& own) {
    return std::make_unique<app::FramesOfLog>(own, log, options.live_robots, unseen, mixed);
  };
  app::SessionSummary summary =
      app::run_session(simulator, session, outputs, [&](scheduler::LiveSource& live) {
        return std::make_unique<scheduler::MixedSource>(log, live, mixed, options);
      });
  summary.has_fingerprint = unseen == app::UnseenFrames::when_changed;
  const int code = report(summary, outputs);
  std::fputs(otherwise_text(log, settings, changed, mixed).c_str(), stdout);

  const scheduler::Log changed_log = scheduler::Log::open(session.log);
  const scheduler::LogDifference difference = app::difference_of(log, changed_log);
  std::fputs(app::to_text(difference).c_str(), stdout);
  if (json) json.fill(app::to_json(difference) + "\n");
  return code;
}

}  // namespace

void add_replay_whatif(app::Command replay) {
  app::Command command = replay.add_subcommand(
      "whatif",
      "Runs a recorded match again with one robot's behaviour changed, and shows what "
      "follows. Frames are drawn for live clients alone; a log that is kept has all of them");
  auto settings = std::make_shared<WhatifSettings>();
  command.add_option("F", settings->file, "The log").required();
  command.add_option("--robot", settings->stand_in.robot, "Whose behaviour is changed").required();
  add_stand_in_options(command, settings->stand_in);
  command
      .add_option("--from", settings->from_s,
                  "Simulated seconds: until then the log decides for all")
      .range(0.0, 9e9);
  command
      .add_option("--others", settings->others,
                  "log: the other robots repeat their decisions; live: their behaviours go on "
                  "and may react")
      .one_of({"log", "live"})
      .show_default();
  command.add_flag("--run-programs", settings->run_programs,
                   "With --others live: start the programs that the log names, without asking");
  command.add_option("--log", settings->session.log, "Keep the changed run's log here");
  command.add_flag("--force", settings->session.force, "Replaces a log that exists");
  command.add_option("--json", settings->json, "Write what differs as seam-diff/1");
  command.footer(
      "Example: seam replay whatif swing.mcap --robot red1 --client 'ball_watcher' --from 1");
  command.callback([settings] {
    if (const int code = what_if(*settings); code != 0) throw ExitCode{code};
  });
}

}  // namespace seam::tools
