// `seam replay verify F`: re-runs a log and compares every hash.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/logs/replay_match.h"
#include "app/trust/log_signature.h"
#include "scheduler/replay/verification.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/input/shown_text.h"
#include "tools/command.h"
#include "tools/replay/replay.h"

namespace seam::tools {
namespace {

using scheduler::Divergence;

struct VerifySettings {
  std::string file;
  std::string json;
  std::string key;  // Public; empty: the log need not be signed.
  bool frames = true;
};

struct Outcome {
  scheduler::Verification found;
  std::optional<mcap::Loss> index;  // What is damaged of the index.
  bool unreadable = false;
};

Outcome damaged(std::string what) {
  Outcome outcome{.unreadable = true};
  outcome.found.divergence = Divergence{SimTime(), "log", "bytes", std::move(what)};
  return outcome;
}

// What is wrong with the file is a result here, not a failure of the command.
Outcome verify(const VerifySettings& settings) {
  try {
    if (!settings.key.empty()) {
      const std::string why =
          app::SigningKey::read_public(settings.key).why_not_signed(settings.file);
      if (!why.empty()) return damaged("not signed: " + why);
    }
    // All of it is read: an index that leaves something out must not hide it.
    const scheduler::Log log = scheduler::Log::open(settings.file, scheduler::LogAccess::scanned);
    if (const std::vector<mcap::Loss> losses = log.losses(); !losses.empty()) {
      return damaged(fmt::format("damaged at offset {}: {}", losses[0].offset, losses[0].what));
    }
    app::ReplayMatch match(log);
    const std::string other_pixels = match.why_other_pixels();
    const bool frames = settings.frames && other_pixels.empty();
    Outcome outcome{scheduler::verify(log, {match.scenario(), match.world(),
                                            frames ? &match.renderer() : nullptr, match.header()})};
    outcome.index = mcap::index_damage(log.file().contents());
    if (!other_pixels.empty()) outcome.found.not_compared.push_back(other_pixels);
    return outcome;
  } catch (const InputError& error) {
    std::string what = error.what();  // Most of these name the file first, as the command does.
    if (what.starts_with(settings.file + ": ")) what.erase(0, settings.file.size() + 2);
    return damaged(what);
  }
}

void write_json(OutputFile& out, const Outcome& outcome) {
  const scheduler::Verification& found = outcome.found;
  nlohmann::ordered_json json = {{"format", "seam-verify/1"},
                                 {"ok", !found.divergence.has_value()}};
  if (found.divergence) {
    json["first_divergence"] = {{"time_ns", found.divergence->time.ns()},
                                {"section", found.divergence->section},
                                {"field", found.divergence->field},
                                {"detail", found.divergence->detail}};
  } else {
    json["first_divergence"] = nullptr;
  }
  json["steps"] = found.steps;
  json["frames"] = found.frames;
  json["verified_until_ns"] = found.until.ns();
  json["has_end"] = found.has_end;
  json["not_compared"] = found.not_compared;
  json["index"] =
      outcome.index ? nlohmann::ordered_json(mcap::index_sentence(*outcome.index)) : nullptr;
  json["readable"] = !outcome.unreadable;
  out.fill(json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

void tell_same(const std::string& file, const scheduler::Verification& found) {
  const auto steps = static_cast<unsigned long long>(found.steps);
  const auto frames = static_cast<unsigned long long>(found.frames);
  const std::string until = app::seconds(found.until);
  if (found.steps == 0) {
    std::printf("%s: nothing to compare: the run ended before its first step%s\n", file.c_str(),
                found.has_end ? "" : "; the log has no end");
  } else if (found.has_end) {
    std::printf("%s: the same: %llu steps and %llu frames up to %s\n", file.c_str(), steps, frames,
                until.c_str());
  } else {
    std::printf(
        "%s: verified up to %s: %llu steps and %llu frames are the same; the log has no end\n",
        file.c_str(), until.c_str(), steps, frames);
  }
  for (const std::string& what : found.not_compared) {
    std::printf("  not compared: %s\n", shown(what).c_str());
  }
}

void verify_log(const VerifySettings& settings) {
  OutputFile json(settings.json, {.inputs = {settings.file}});
  const Outcome outcome = verify(settings);
  if (json) write_json(json, outcome);
  if (outcome.index) {
    std::printf("%s: %s; write it anew: seam replay recover %s --out FILE\n", settings.file.c_str(),
                mcap::index_sentence(*outcome.index).c_str(), settings.file.c_str());
  }
  if (!settings.key.empty() && !outcome.unreadable)
    std::printf("%s: signed with the key of %s\n", settings.file.c_str(), settings.key.c_str());
  if (!outcome.found.divergence) return tell_same(settings.file, outcome.found);
  const Divergence& first = *outcome.found.divergence;
  if (outcome.unreadable) {
    std::printf("%s: cannot be verified: %s\n", settings.file.c_str(), shown(first.detail).c_str());
  } else {
    std::printf("%s: first divergence at %s (%lld ns): section %s, field %s\n  %s\n",
                settings.file.c_str(), app::seconds(first.time).c_str(),
                static_cast<long long>(first.time.ns()), shown(first.section).c_str(),
                first.field.empty() ? "unknown" : shown(first.field).c_str(),
                shown(first.detail).c_str());
  }
  throw ExitCode{1};
}

}  // namespace

void add_replay_verify(app::Command replay) {
  app::Command command = replay.add_subcommand(
      "verify",
      "Re-runs a log and compares all that it holds; names the first divergence by time, "
      "section and field");
  auto settings = std::make_shared<VerifySettings>();
  command.add_option("F", settings->file, "The log").required();
  command.add_option("--json", settings->json, "Write the result as seam-verify/1 to this file");
  command.add_option("--key", settings->key,
                     "The log must be signed (run --sign): the public key, Ed25519 in PEM");
  command.add_flag("--frames,!--no-frames", settings->frames,
                   "Make and compare the frames too (the default)");
  command.footer(
      "Lists what was not compared. Exit code 0: the same; 1: a divergence, or the log cannot\n"
      "be read.\n"
      "Example: seam replay verify swing.mcap --json result.json");
  command.callback([settings] { verify_log(*settings); });
}

}  // namespace seam::tools
