// `seam run SCENARIO`: server and behaviours in one process tree.
#include "app/camera_warnings.h"
#include "app/session/run_session.h"
#include "app/session/runs_made_here.h"
#include "app/session/session_outputs.h"
#include "tools/command.h"

namespace seam::tools {

void add_run(app::Command app) {
  struct Options {
    std::string scenario;
    app::SessionOptions session;
    app::SimulatorOptions simulator;
  };
  app::Command command = app.add_subcommand(
      "run", "Runs a scenario with its behaviours, each a process of its own, in lockstep");
  auto options = std::make_shared<Options>();
  command.add_option("SCENARIO", options->scenario, "A seam-scenario/1 file").required();
  app::add_session_options(command, options->session, options->simulator);
  command.footer(
      "Examples:\n  seam run scenarios/head_swing.yaml --log run.mcap --frames frames/\n"
      "  seam run scenarios/head_swing.yaml --seed 2 --json summary.json\n"
      "Exit code 0 at the scenario's end and after Ctrl-C (the log is whole), 1 when the run was\n"
      "aborted or an input is bad, 2 for wrong use.");
  command.callback([options] {
    options->session.inputs = {options->scenario};
    app::SessionOutputs outputs(options->session);
    app::Simulator simulator = app::make_simulator(
        app::load_scenario(options->scenario, options->simulator), options->simulator);
    app::warn_of_robots(simulator);
    if (outputs.log) app::RunsMadeHere().note(simulator);
    const app::SessionSummary summary = app::run_session(simulator, options->session, outputs);
    if (const int code = report(summary, outputs); code != 0) throw ExitCode{code};
  });
}

}  // namespace seam::tools
