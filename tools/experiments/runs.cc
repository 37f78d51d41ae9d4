#include "tools/experiments/runs.h"

#include <algorithm>

#include "app/session/behaviours.h"
#include "app/session/run_session.h"
#include "app/session/session_outputs.h"
#include "app/session/standbys.h"
#include "app/simulator.h"
#include "app/sweep/sweep_progress.h"
#include "app/sweep/workers.h"
#include "scheduler/log/log.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/hash.h"
#include "sim_core/base/output.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMade = "made";

struct Paths {
  fs::path scenario, log, partial_log, key;
  Paths(const fs::path& folder, const std::string& name)
      : scenario(folder / (name + ".yaml")),
        log(folder / (name + ".mcap")),
        partial_log(folder / (name + ".part.mcap")),
        key(folder / (name + ".key")) {}
};

// A run is made again when its scenario, the simulator or a program that plays in it
// has changed.
// `programs` holds the content of those read before, by name.
std::string key_of(const Scenario& scenario, const std::string& text,
                   std::map<std::string, std::string>& programs) {
  Hasher hasher;
  hasher.add(std::string_view(text));
  std::string& simulator = programs["/proc/self/exe"];
  if (simulator.empty()) simulator = read_file("/proc/self/exe");
  hasher.add(std::string_view(simulator));
  for (const RobotSpec& robot : scenario.robots) {
    if (robot.behaviour.command.empty()) continue;
    const std::string& name = robot.behaviour.command.front();
    if (!programs.contains(name)) programs[name] = read_file(app::find_behaviour(name, robot.id));
    hasher.add(std::string_view(programs[name]));
  }
  return to_hex(hasher.digest());
}

bool is_made(const Paths& paths, const std::string& key) {
  return fs::exists(paths.log) && fs::exists(paths.key) && read_file(paths.key) == key;
}

// A run that is to be made, and what it was made from.
struct MissingRun {
  const PlannedRun* run;
  std::string key;
};

// In a worker: why the run failed; "made" where it did not, nothing where a signal stopped it.
std::string make_run(const PlannedRun& run, const Paths& paths, int render_workers,
                     app::Standbys& standbys) {
  try {
    app::SessionOptions options{
        .log = paths.partial_log.string(), .force = true, .progress = false, .standbys = &standbys};
    app::Simulator simulator =
        app::make_simulator(run.scenario, {.render_workers = render_workers});
    app::SessionOutputs outputs(options);
    const app::SessionSummary summary = app::run_session(simulator, options, outputs);
    if (summary.end == scheduler::EndReason::stopped) return "";
    return summary.end == scheduler::EndReason::aborted ? summary.abort_reason : kMade;
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace

void make_runs(const std::vector<PlannedRun>& runs, const fs::path& folder, int parallel) {
  fs::create_directories(folder);
  std::vector<MissingRun> missing;
  std::map<std::string, std::string> programs;
  for (const PlannedRun& run : runs) {
    const std::string text = run.scenario.to_yaml();
    const std::string key = key_of(run.scenario, text, programs);
    const Paths paths(folder, run.name);
    if (is_made(paths, key)) continue;
    write_file_atomically(paths.scenario, text);
    missing.push_back({&run, key});
  }
  const int render_workers = app::cores_for_each(parallel);
  app::SweepProgress progress(missing.size());
  const auto fail = [&](uint64_t job, const std::string& how) {
    throw InputError(fmt::format("run {} failed: {}", missing[job].run->name, how));
  };
  app::Standbys standbys;  // Each worker fills its own copy.
  size_t next = 0;
  const app::WorkerCalls calls{
      .next =
          [&] { return next < missing.size() ? std::optional<uint64_t>(next++) : std::nullopt; },
      .work =
          [&](uint64_t job) {
            const PlannedRun& run = *missing[job].run;
            return make_run(run, Paths(folder, run.name), render_workers, standbys);
          },
      .done =
          [&](uint64_t job, const std::string& result) {
            if (result != kMade) fail(job, result);
            const Paths paths(folder, missing[job].run->name);
            fs::rename(paths.partial_log, paths.log);
            write_file_atomically(paths.key, missing[job].key);
            progress.count(false);
          },
      .died = fail,
      .tick = [&] { progress.show(); }};
  const auto workers = std::min(static_cast<size_t>(std::max(1, parallel)), missing.size());
  if (!app::run_in_workers(static_cast<int>(workers), calls))
    throw InputError("interrupted: runs that are finished are kept, and the same command goes on");
}

LoggedValues logged_values(const fs::path& path, int robot) {
  LoggedValues values;
  const scheduler::Log log = scheduler::Log::open(path);
  scheduler::LogCursor cursor(log, {scheduler::Topic::turn});
  while (auto record = cursor.next()) {
    const auto& turn = std::get<scheduler::TurnRecord>(*record);
    for (const scheduler::Answer& answer : turn.turn.answers) {
      if (answer.robot != robot) continue;
      for (const scheduler::DebugItem& item : answer.decision.debug) {
        if (item.kind == scheduler::DebugItem::Kind::value)
          values[item.name].push_back({turn.time, item.value});
      }
    }
  }
  return values;
}

}  // namespace seam::tools
