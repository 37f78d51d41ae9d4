// `seam replay verify F`: re-runs a log and compares every hash.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/logs/replay_match.h"
#include "scheduler/loop/simulation.h"
#include "scheduler/replay/player.h"
#include "scheduler/replay/verifier.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/input/shown_text.h"
#include "tools/command.h"
#include "tools/replay/replay.h"

namespace seam::tools {
namespace {

using scheduler::Divergence;

struct Settings {
  std::string file;
  std::string json;
  bool frames = true;
};

struct Outcome {
  std::optional<Divergence> divergence;
  uint64_t steps = 0;
  uint64_t frames = 0;
  SimTime until;
  bool unreadable = false;
};

Outcome re_run(const scheduler::Log& log, bool frames) {
  app::ReplayMatch match(log);
  scheduler::RunControl control;
  scheduler::LogSource decisions(log);
  scheduler::Verifier verifier(log, match.world(), control);
  if (!frames) verifier.ignore_frames();
  scheduler::Simulation simulation({match.scenario(),
                                    match.world(),
                                    decisions,
                                    control,
                                    frames ? &match.renderer() : nullptr,
                                    {&verifier},
                                    match.header()});
  simulation.run();
  return {verifier.divergence(), verifier.steps(), verifier.frames(), verifier.verified_until()};
}

// What is wrong with the file is a result here, not a failure of the command.
Outcome verify(const Settings& settings) {
  try {
    const scheduler::Log log = scheduler::Log::open(settings.file);
    Outcome outcome = re_run(log, settings.frames);
    const std::vector<mcap::Loss> losses = log.losses();
    if (!outcome.divergence && !losses.empty()) {
      outcome.divergence =
          Divergence{outcome.until, "log", "bytes",
                     fmt::format("damaged at offset {}: {}", losses[0].offset, losses[0].what)};
      outcome.unreadable = true;
    }
    return outcome;
  } catch (const InputError& error) {
    Outcome outcome;
    outcome.divergence = Divergence{SimTime(), "log", "bytes", error.what()};
    outcome.unreadable = true;
    return outcome;
  }
}

void write_json(const std::string& path, const Outcome& outcome) {
  nlohmann::ordered_json json = {{"format", "seam-verify/1"},
                                 {"ok", !outcome.divergence.has_value()}};
  if (outcome.divergence) {
    json["first_divergence"] = {{"time_ns", outcome.divergence->time.ns()},
                                {"section", outcome.divergence->section},
                                {"field", outcome.divergence->field},
                                {"detail", outcome.divergence->detail}};
  } else {
    json["first_divergence"] = nullptr;
  }
  json["steps"] = outcome.steps;
  json["frames"] = outcome.frames;
  json["verified_until_ns"] = outcome.until.ns();
  json["readable"] = !outcome.unreadable;
  write_file_atomically(path, json.dump(2) + "\n");
}

void run(const Settings& settings) {
  const Outcome outcome = verify(settings);
  if (!settings.json.empty()) write_json(settings.json, outcome);
  if (!outcome.divergence) {
    std::printf("%s: the same: %llu steps and %llu frames up to %s\n", settings.file.c_str(),
                static_cast<unsigned long long>(outcome.steps),
                static_cast<unsigned long long>(outcome.frames),
                app::seconds(outcome.until).c_str());
    return;
  }
  const Divergence& first = *outcome.divergence;
  if (outcome.unreadable) {
    std::printf("%s: cannot be verified: %s\n", settings.file.c_str(), shown(first.detail).c_str());
  } else {
    std::printf("%s: first divergence at %s (%lld ns): section %s, field %s\n  %s\n",
                settings.file.c_str(), app::seconds(first.time).c_str(),
                static_cast<long long>(first.time.ns()), first.section.c_str(),
                first.field.empty() ? "unknown" : first.field.c_str(), shown(first.detail).c_str());
  }
  throw ExitCode{1};
}

}  // namespace

void add_replay_verify(app::Command replay) {
  app::Command command = replay.add_subcommand(
      "verify",
      "Re-runs a log and compares every hash; names the first divergence by time, "
      "section and field");
  auto settings = std::make_shared<Settings>();
  command.add_option("F", settings->file, "The log").required();
  command.add_option("--json", settings->json, "Write the result as seam-verify/1 to this file");
  command.add_flag("--frames,!--no-frames", settings->frames,
                   "Make and compare the frames too (the default)");
  command.footer(
      "Exit code 0: the same; 1: a divergence, or the log cannot be read.\n"
      "Example: seam replay verify swing.mcap --json result.json");
  command.callback([settings] { run(*settings); });
}

}  // namespace seam::tools
