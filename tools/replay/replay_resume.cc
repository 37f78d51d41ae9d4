// `seam replay resume F --log G`: goes on where a log ends.
//
// The behaviours are started anew and get everything from the start, while the log decides; so
// they come to know what they would have known. Where the log ends, they decide.
#include <cstdio>

#include "app/logs/replay_match.h"
#include "app/session/run_session.h"
#include "app/session/runs_made_here.h"
#include "app/session/session_outputs.h"
#include "app/trust/program_consent.h"
#include "scheduler/replay/player.h"
#include "scheduler/replay/verifier.h"
#include "sim_core/base/error.h"
#include "tools/command.h"
#include "tools/replay/replay.h"

namespace seam::tools {
namespace {

struct ResumeSettings {
  std::string file;
  bool run_programs = false;
  app::SessionOptions session;
  app::SimulatorOptions simulator;
};

int resume(const ResumeSettings& settings) {
  app::SessionOutputs outputs(settings.session);
  const scheduler::Log log = scheduler::Log::open(settings.file);
  if (log.end() && log.end()->reason == scheduler::EndReason::finished) {
    std::printf("%s is of a finished run: it is run again to its end\n", settings.file.c_str());
  }
  app::Simulator simulator = app::make_simulator(log.header(), settings.simulator);
  app::require_consent(app::programs_of(simulator.scenario),
                       settings.run_programs || app::RunsMadeHere().holds(simulator));
  app::RunsMadeHere().note(simulator);
  scheduler::MixedReport mixed;
  // The part that the log holds must come out the same; the run goes on in any case.
  scheduler::RunControl unused;
  scheduler::Verifier verifier(log, simulator.world, unused);
  const app::SessionSummary summary =
      app::run_session(simulator, settings.session, outputs,
                       [&](scheduler::LiveSource& live) {
                         return std::make_unique<scheduler::MixedSource>(log, live, mixed);
                       },
                       {&verifier});
  if (mixed.live_since) {
    std::printf("live since %s\n", app::seconds(*mixed.live_since).c_str());
  }
  if (mixed.different_decisions > 0) {
    std::printf(
        "warning: %llu of %llu decisions of the live behaviours were others than the log's: "
        "they do not repeat themselves\n",
        static_cast<unsigned long long>(mixed.different_decisions),
        static_cast<unsigned long long>(mixed.compared_decisions));
  }
  const int code = report(summary, outputs);
  // Who stops the run while the log still decides has not left it.
  const bool stopped_before = summary.end == scheduler::EndReason::stopped && !mixed.live_since;
  if (verifier.divergence() && !stopped_before) {
    std::printf("the resumed run left the log at %s: section %s, field %s\n",
                app::seconds(verifier.divergence()->time).c_str(),
                verifier.divergence()->section.c_str(), verifier.divergence()->field.c_str());
    return 1;
  }
  return code;
}

}  // namespace

void add_replay_resume(app::Command replay) {
  app::Command command = replay.add_subcommand(
      "resume",
      "Goes on from a log with the scenario's behaviours, to the same end as a run that "
      "was not interrupted");
  auto settings = std::make_shared<ResumeSettings>();
  command.add_option("F", settings->file, "The log, whole or of a killed run").required();
  command.add_option("--log", settings->session.log, "The log of the whole run, a new file")
      .required();
  command.add_flag("--run-programs", settings->run_programs,
                   "Start the programs that the log names, without asking");
  command.add_option("--json", settings->session.json, "Writes the summary here");
  command.add_option("--frames", settings->session.frames, "Writes frames into this folder");
  command.add_flag("--force", settings->session.force,
                   "Replaces a log and frames of an earlier run");
  command.footer(
      "Exit code 0: resumed; 1: the run left the log, or was aborted.\n"
      "Example: seam replay resume killed.mcap --log whole.mcap --run-programs");
  command.callback([settings] {
    settings->session.inputs = {settings->file};
    if (const int code = resume(*settings); code != 0) throw ExitCode{code};
  });
}

}  // namespace seam::tools
