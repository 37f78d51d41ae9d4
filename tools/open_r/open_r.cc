// `seam open-r build FOLDER`: builds an OPEN-R program for an AIBO from its own folder, and runs it
// in a scenario. `seam open-r stub FILE`: the stub of an object alone.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "app/data_file.h"
#include "app/session/run_session.h"
#include "app/session/session_outputs.h"
#include "effects/formulas/formula_parameter.h"
#include "open_r/files/fault.h"
#include "open_r/files/stub_settings.h"
#include "open_r/programs/builder.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"
#include "sim_core/input/shown_text.h"
#include "sim_core/system/own_files.h"
#include "tools/command.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

struct BuildOptions {
  std::vector<std::string> folders, variables;
  std::string out = "open_r_program", design = "ERS-210", compiler = "c++", scenario, robot, log;
  bool run = false;
};

fs::path header_folder() {
  const fs::path installed = find_shared("open_r/include");
  return installed.empty() ? fs::path(SEAM_SOURCE_DIR) / "open_r/include" : installed;
}

// Variables for Makefiles: the design's name as programs switch on it (ERS210), the environment's,
// then those of the command line.
std::map<std::string, std::string> given_variables(const std::vector<std::string>& given,
                                                   std::string design) {
  std::erase(design, '-');
  std::map<std::string, std::string> variables{{"AIBO_MODEL", design}};
  for (const char* name : {"AIBO_MODEL", "OPENRSDK_ROOT"})
    if (const char* value = std::getenv(name); value != nullptr) variables[name] = value;
  for (const std::string& text : given) {
    const size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw UsageError(fmt::format("--make {}: expected NAME=VALUE", text));
    variables[text.substr(0, equals)] = text.substr(equals + 1);
  }
  return variables;
}

// A robot that sees a ball, for programs that come without a scenario.
std::string scenario_text(const fs::path& stick, const std::string& design) {
  const auto in_quotes = [](const fs::path& path) {
    return effects::yaml_quoted(fs::absolute(path).string());
  };
  return fmt::format(
      "# Written by `seam open-r build`: an ERS-210 that runs the program beside this file.\n"
      "format: seam-scenario/1\nname: open_r\nduration_s: 10\nseed: 1\n"
      "field: {}\nball: {{x_m: 0.6, y_m: 0.15}}\nrobots:\n  - id: aibo\n    team: red\n"
      "    pose: {{x_m: -0.2, y_m: 0, theta_rad: 0}}\n    body: {}\n    camera: {{model: {}}}\n"
      "    behaviour: {{command: [open_r, {}, --design, {}], clock: {{period_s: 0.008}}}}\n",
      in_quotes(app::data_file("models/field_2002.yaml")),
      in_quotes(app::data_file("models/robot_ers210.yaml")),
      in_quotes(app::data_file("models/ers210.yaml")), in_quotes(stick), design);
}

// The robot of a scenario that is to run the program: the one named, or the only one.
std::string robot_of(const Scenario& scenario, const std::string& named) {
  std::vector<std::string> ids;
  for (const auto& robot : scenario.robots) ids.push_back(robot.id);
  if (!named.empty() && std::find(ids.begin(), ids.end(), named) != ids.end()) return named;
  const std::string known = fmt::format("{}", fmt::join(ids, ", "));
  if (!named.empty())
    throw UsageError(fmt::format("--robot {}: not in the scenario, whose robots are: {}", named,
                                 known.empty() ? "none" : known));
  if (ids.size() == 1) return ids[0];
  throw UsageError(
      fmt::format("{} robots in the scenario: name one by --robot: {}", ids.size(), known));
}

// A log that an earlier build wrote may be overwritten, a file that is none may not.
void check_log(const fs::path& log) {
  constexpr std::string_view kMagic = "\x89MCAP0\r\n";
  std::error_code unknown;
  if (log.empty() || !fs::is_regular_file(log, unknown)) return;
  std::string start(kMagic.size(), '\0');
  std::ifstream(log, std::ios::binary).read(start.data(), std::ssize(start));
  if (start != kMagic)
    throw InputError(
        fmt::format("{}: exists and is no log; give another name for the log", log.string()));
}

// What is wrong is said before the minutes of a build.
void check_options(const BuildOptions& options) {
  check_log(options.log);
  if (options.scenario.empty() && !options.robot.empty())
    throw UsageError("--robot: give --scenario, too, the scenario with that robot");
  app::SimulatorOptions simulator_options;
  if (!options.scenario.empty())
    robot_of(app::load_scenario(options.scenario, simulator_options), options.robot);
}

void run(const BuildOptions& options, const fs::path& stick, const std::string& written) {
  const std::string file = options.scenario.empty() ? written : options.scenario;
  app::SimulatorOptions simulator_options;
  app::SessionOptions session;
  session.inputs = {file};
  session.log = options.log;
  session.force = true;  // The build before wrote the log of the same name.
  if (!options.scenario.empty()) {
    const Scenario scenario = app::load_scenario(file, simulator_options);
    const std::string robot = robot_of(scenario, options.robot);
    session.commands[robot] = {"open_r", fs::absolute(stick).string(), "--design", options.design};
    for (size_t i = 0; i < scenario.robots.size(); ++i)
      if (scenario.robots[i].id == robot)
        simulator_options.changes.push_back(
            fmt::format("robots[{}].behaviour.clock.period_s=0.008", i));
  }
  app::SessionOutputs outputs(session);
  app::Simulator simulator =
      app::make_simulator(app::load_scenario(file, simulator_options), simulator_options);
  const app::SessionSummary summary = app::run_session(simulator, session, outputs);
  if (const int code = app::report(summary, outputs); code != 0) throw ExitCode{code};
}

void build(const BuildOptions& options) {
  check_options(options);
  std::vector<fs::path> folders(options.folders.begin(), options.folders.end());
  const fs::path out = options.out;
  open_r::BuildReport report;
  try {
    const open_r::ProgramPlan plan = open_r::plan_program(
        folders, options.design, given_variables(options.variables, options.design), out);
    const open_r::Toolchain tools{options.compiler, "cc", header_folder()};
    report = open_r::build_program(plan, tools, out, [](const std::string& line) {
      std::puts(shown_lines(line).c_str());
      std::fflush(stdout);  // Before what the end says on stderr.
    });
  } catch (const open_r::Fault& fault) {
    throw InputError(fault.what());
  }
  const fs::path stick = out / "MS", written = out / "scenario.yaml";
  const size_t lacking = report.failed.size() + report.missing.size();
  // Without an object that nobody has the sources of, the others may still be tried.
  if (report.failed.empty() && report.built > 0)
    OutputFile(written).fill(scenario_text(stick, options.design));
  if (lacking > 0 || report.built == 0)
    throw InputError(
        fmt::format("{} of {} objects were built: the lines above say what the rest "
                    "lacks",
                    report.built, report.built + lacking));
  if (options.run || !options.scenario.empty() || !options.log.empty())
    run(options, stick, written.string());
  else
    std::printf("run it: seam run %s\n", written.c_str());
}

void write_stub(const std::string& file, const fs::path& out) {
  try {
    const open_r::StubSettings stub = open_r::read_stub_settings(file, read_file(file));
    fs::create_directories(out);
    const std::pair<std::string, std::string> files[] = {
        {"def.h", open_r::definitions_header(stub)},
        {"entry.h", open_r::entries_header(stub)},
        {stub.object + "Stub.cc", open_r::stub_source(stub)}};
    for (const auto& [name, text] : files) OutputFile(out / name).fill(text);
  } catch (const open_r::Fault& fault) {
    throw InputError(fault.what());
  }
}

void add_build(app::Command app) {
  app::Command command =
      app.add_subcommand("build", "Builds an unchanged program, and runs it in a scenario");
  auto options = std::make_shared<BuildOptions>();
  command
      .add_option("FOLDER", options->folders,
                  "The program's folder, then folders of more of its objects")
      .required();
  command.add_option("--out", options->out, "Folder for the memory stick and a scenario")
      .show_default();
  command.add_option("--design", options->design, "The robot that the program finds itself on")
      .one_of({"ERS-210", "ERS-7"})
      .show_default();
  command
      .add_option("--compiler", options->compiler,
                  "A C++ compiler: g++, or one that takes its flags")
      .show_default();
  command.add_option("--make", options->variables, "NAME=VALUE: a variable of the Makefiles");
  command.add_flag("--run", options->run, "Runs the program in the scenario that is written");
  command.add_option("--scenario", options->scenario, "Runs the program in this scenario instead");
  command.add_option("--robot", options->robot,
                     "The robot of that scenario which runs the program");
  command.add_option("--log", options->log, "Runs the program, and writes the replay log here");
  command.footer(
      "Example: seam open-r build open_r/examples/moving_head --out head --log head.mcap\n"
      "What the program lacks is named, line by line. Exit code 1 where an object is not built.");
  command.callback([options] { build(*options); });
}

void add_stub(app::Command app) {
  app::Command command = app.add_subcommand(
      "stub", "Makes an object's stub (def.h, entry.h, NAMEStub.cc) from its stub.cfg");
  struct Options {
    std::string file, out = ".";
  };
  auto options = std::make_shared<Options>();
  command.add_option("FILE", options->file, "A stub.cfg").required();
  command.add_option("--out", options->out, "Folder for the files").show_default();
  command.footer(
      "Example: seam open-r stub open_r/examples/moving_head/SwingHead/stub.cfg --out made");
  command.callback([options] { write_stub(options->file, options->out); });
}

}  // namespace

void add_open_r(app::Command app) {
  app::Command command =
      app.add_subcommand("open-r", "Builds and runs OPEN-R programs for an AIBO");
  command.require_subcommand();
  add_build(command);
  add_stub(command);
}

}  // namespace seam::tools
