// `seam serve SCENARIO`: the server alone, for clients anywhere.
#include "app/session/behaviours.h"
#include "app/session/run_session.h"
#include "app/session/session_outputs.h"
#include "sim_core/base/error.h"
#include "tools/command.h"
#include "tools/dm_env_rpc/environment_server.h"
#include "tools/dm_env_rpc/world_kind.h"

namespace seam::tools {

namespace {

struct ServeOptions {
  std::string scenario;
  std::vector<std::string> listen{"127.0.0.1:7210"};
  app::SessionOptions session;
  app::SimulatorOptions simulator;
  dm::LearningOptions learning;
};

void add_options(app::Command command, ServeOptions& options) {
  command.add_option("SCENARIO", options.scenario, "A seam-scenario/1 file").required();
  command
      .add_option("--listen", options.listen,
                  "host:port (port 0: a free one) or unix:/path; may be given several times")
      .show_default();
  command.add_option("--certs", options.session.certificates,
                     "Folder with ca.pem, server.pem, server.key: TLS with client certificates; "
                     "needed beyond Unix sockets and loopback");
  command.add_option(
      "--tokens", options.session.token_file,
      "Writes the robots', renderers' and the supervisor's tokens here (readable by you alone); "
      "tokens that the scenario does not give are drawn anew");
  command.add_option("--drive", options.session.driven,
                     "ROBOT, or '*' for all: a script drives them, and may take its time whatever\n"
                     "the scenario says of silence; the behaviours of all others are started");
  command.add_option("--lines", options.session.lines,
                     "With --drive: a Unix socket for direct lines (proto/line.h)");
  command.add_flag("--until-eof", options.session.until_eof,
                   "The run stops when standard input ends: with the program that started it");
  command.add_flag(
      "--dm-env-rpc", options.learning.asked,
      "Serves learning programs, by protocol version 1 of dm_env_rpc: each sequence is\n"
      "a run, in a process of its own; agents join as the robots of --drive, or as any");
  command
      .add_option("--worlds", options.learning.worlds,
                  "With --dm-env-rpc: how many worlds there may be at once")
      .range(1, 64)
      .show_default();
  command.add_option("--logs", options.learning.logs,
                     "With --dm-env-rpc: a folder that takes the replay log of each sequence, as\n"
                     "WORLD-NUMBER.mcap");
  app::add_session_options(command, options.session, options.simulator);
}

// Learning programs make the runs.
void serve_learning(const ServeOptions& options) {
  dm::serve_environment(
      dm::make_world_kind(options.scenario, options.session, options.simulator, options.learning),
      {.addresses = options.listen,
       .tls = app::read_certificates(options.session.certificates),
       .until_eof = options.session.until_eof});
}

}  // namespace

void add_serve(app::Command app) {
  app::Command command = app.add_subcommand("serve", "Serves a scenario to clients anywhere");
  auto options = std::make_shared<ServeOptions>();
  add_options(command, *options);
  command.footer(
      "Examples:\n  seam serve scenarios/head_swing.yaml --listen unix:/tmp/seam.sock --tokens "
      "t.yaml\n"
      "  seam certs certs && seam serve scenarios/head_swing.yaml --listen 0.0.0.0:7210 --certs "
      "certs\n"
      "  seam serve scenarios/head_swing.yaml --dm-env-rpc --listen unix:/tmp/dm.sock\n"
      "The clock starts when the clients are there. Exit codes as `seam run`.");
  command.callback([options] {
    if (options->learning.asked) return serve_learning(*options);
    if (!options->learning.logs.empty()) throw UsageError("--logs: expected --dm-env-rpc with it");
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
