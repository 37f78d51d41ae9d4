// `seam serve SCENARIO`: the server alone, for clients anywhere.
#include "app/session/behaviours.h"
#include "app/session/run_session.h"
#include "app/session/session_outputs.h"
#include "sim_core/base/error.h"
#include "tools/command.h"

namespace seam::tools {

void add_serve(app::Command app) {
  struct Options {
    std::string scenario;
    std::vector<std::string> listen{"127.0.0.1:7210"};
    app::SessionOptions session;
    app::SimulatorOptions simulator;
  };
  app::Command command = app.add_subcommand("serve", "Serves a scenario to clients anywhere");
  auto options = std::make_shared<Options>();
  command.add_option("SCENARIO", options->scenario, "A seam-scenario/1 file").required();
  command
      .add_option("--listen", options->listen,
                  "host:port (port 0: a free one) or unix:/path; may be given several times")
      .show_default();
  command.add_option("--certs", options->session.certificates,
                     "Folder with ca.pem, server.pem, server.key: TLS with client certificates; "
                     "needed beyond Unix sockets and loopback");
  command.add_option(
      "--tokens", options->session.token_file,
      "Writes the robots', renderers' and the supervisor's tokens here (readable by you alone); "
      "tokens that the scenario does not give are drawn anew");
  command.add_option("--drive", options->session.driven,
                     "ROBOT, or '*' for all: a script drives them, and may take its time whatever\n"
                     "the scenario says of silence; the behaviours of all others are started");
  command.add_option("--lines", options->session.lines,
                     "With --drive: a Unix socket for direct lines (proto/line.h)");
  command.add_flag("--until-eof", options->session.until_eof,
                   "The run stops when standard input ends: with the program that started it");
  app::add_session_options(command, options->session, options->simulator);
  command.footer(
      "Examples:\n  seam serve scenarios/head_swing.yaml --listen unix:/tmp/seam.sock --tokens "
      "t.yaml\n"
      "  seam certs certs && seam serve scenarios/head_swing.yaml --listen 0.0.0.0:7210 --certs "
      "certs\n"
      "The clock starts when the clients are there. Exit codes as `seam run`.");
  command.callback([options] {
    options->session.addresses = options->listen;
    options->session.inputs = {options->scenario};
    options->session.start_behaviours = !options->session.driven.empty();
    if (!options->session.lines.empty() && options->session.driven.empty())
      throw UsageError("--lines: expected --drive with it");
    app::SessionOutputs outputs(options->session);
    app::Simulator simulator = app::make_simulator(
        app::load_scenario(options->scenario, options->simulator), options->simulator);
    app::require_driven_robots(options->session.driven, simulator.scenario);
    const app::SessionSummary summary = app::run_session(simulator, options->session, outputs);
    if (const int code = report(summary, outputs); code != 0) throw ExitCode{code};
  });
}

}  // namespace seam::tools
