#include "tools/experiments/runs.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <deque>

#include "app/session/behaviours.h"
#include "scheduler/log/log.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/hash.h"
#include "sim_core/base/output.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

struct Paths {
  fs::path scenario, log, partial_log, messages, key;
  Paths(const fs::path& folder, const std::string& name)
      : scenario(folder / (name + ".yaml")),
        log(folder / (name + ".mcap")),
        partial_log(folder / (name + ".part.mcap")),
        messages(folder / (name + ".txt")),
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

pid_t start(const fs::path& seam, const Paths& paths) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  const int out = ::open(paths.messages.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  ::dup2(out, 1);
  ::dup2(out, 2);
  ::execl(seam.c_str(), "seam", "run", paths.scenario.c_str(), "--log", paths.partial_log.c_str(),
          static_cast<char*>(nullptr));
  ::_exit(127);
}

struct Running {
  pid_t child;
  const PlannedRun* run;
  std::string key;
};

void finish(const Running& running, int status, const fs::path& folder) {
  const Paths paths(folder, running.run->name);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw InputError(
        fmt::format("run {}: seam run failed: {}", running.run->name, read_file(paths.messages)));
  }
  fs::rename(paths.partial_log, paths.log);
  write_file_atomically(paths.key, running.key);
  fs::remove(paths.messages);
}

}  // namespace

void make_runs(const std::vector<PlannedRun>& runs, const fs::path& folder, int parallel) {
  fs::create_directories(folder);
  const fs::path seam = fs::read_symlink("/proc/self/exe");
  const bool shown = ::isatty(2) != 0;
  std::deque<Running> running;
  size_t done = 0;
  std::map<std::string, std::string> programs;
  const auto wait_for_first = [&] {
    int status = 0;
    ::waitpid(running.front().child, &status, 0);
    finish(running.front(), status, folder);
    running.pop_front();
    ++done;
    if (shown) std::fprintf(stderr, "\r%zu of %zu runs ", done, runs.size());
  };
  try {
    for (const PlannedRun& run : runs) {
      const std::string text = run.scenario.to_yaml();
      const std::string key = key_of(run.scenario, text, programs);
      const Paths paths(folder, run.name);
      if (is_made(paths, key)) {
        ++done;
        continue;
      }
      while (static_cast<int>(running.size()) >= parallel) wait_for_first();
      write_file_atomically(paths.scenario, text);
      running.push_back({start(seam, paths), &run, key});
    }
    while (!running.empty()) wait_for_first();
  } catch (...) {
    for (const Running& other : running) ::waitpid(other.child, nullptr, 0);
    throw;
  }
  if (shown) std::fprintf(stderr, "\n");
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
