// `seam replay recover F --out G`: a whole log from a damaged one.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/logs/replay_match.h"
#include "scheduler/log/log_recovery.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "tools/command.h"
#include "tools/replay/replay.h"

namespace seam::tools {
namespace {

struct RecoverSettings {
  std::string file;
  std::string out;
  std::string json;
};

void write_json(OutputFile& out, const scheduler::Recovery& recovery) {
  nlohmann::ordered_json losses = nlohmann::ordered_json::array();
  for (const auto& loss : recovery.losses) {
    nlohmann::ordered_json entry = {{"offset", loss.place.offset},
                                    {"bytes", loss.place.bytes},
                                    {"what", loss.place.what},
                                    {"from_ns", loss.from.ns()},
                                    {"to_ns", nullptr}};
    if (loss.to) entry["to_ns"] = loss.to->ns();
    losses.push_back(std::move(entry));
  }
  nlohmann::ordered_json behind = nullptr;
  if (const auto& rest = recovery.behind_end) {
    behind = {{"offset", rest->offset}, {"bytes", rest->bytes}, {"what", rest->what}};
  }
  const nlohmann::ordered_json json = {
      {"format", "seam-recover/1"},
      {"whole", recovery.whole()},
      {"messages", recovery.messages},
      {"chunks", recovery.chunks},
      {"unknown_messages", recovery.unknown_messages},
      {"losses", std::move(losses)},
      {"index",
       recovery.index ? nlohmann::ordered_json(mcap::index_sentence(*recovery.index)) : nullptr},
      {"behind_end", std::move(behind)}};
  out.fill(json.dump(2) + "\n");
}

void print(const scheduler::Recovery& recovery) {
  for (const auto& loss : recovery.losses) {
    std::printf("lost: %llu bytes at offset %llu: %s; simulated time after %s%s\n",
                static_cast<unsigned long long>(loss.place.bytes),
                static_cast<unsigned long long>(loss.place.offset), loss.place.what.c_str(),
                app::seconds(loss.from).c_str(),
                loss.to ? (" up to " + app::seconds(*loss.to)).c_str() : ", to the end");
  }
  if (const auto& rest = recovery.behind_end) {
    std::printf("behind the end of the log, not copied: %llu bytes at offset %llu: %s\n",
                static_cast<unsigned long long>(rest->bytes),
                static_cast<unsigned long long>(rest->offset), rest->what.c_str());
  }
  if (recovery.index) {
    std::printf("%s; a new index was written\n", mcap::index_sentence(*recovery.index).c_str());
  }
  if (recovery.unknown_messages > 0) {
    std::printf("lost: %llu messages of channels whose definition is lost\n",
                static_cast<unsigned long long>(recovery.unknown_messages));
  }
}

void recover(const RecoverSettings& settings) {
  const OutputRules rules{.inputs = {settings.file}};
  OutputFile json(settings.json, rules);
  // Renamed when it is whole, so that nobody takes half of it for a whole log.
  const std::unique_ptr<mcap::Output> output = mcap::create_file(settings.out, rules);
  const scheduler::Recovery recovery =
      scheduler::recover_log(mcap::open_file(settings.file), *output);
  output->close();
  if (json) write_json(json, recovery);
  print(recovery);
  std::printf("%s: %llu messages in %llu chunks%s\n", settings.out.c_str(),
              static_cast<unsigned long long>(recovery.messages),
              static_cast<unsigned long long>(recovery.chunks),
              recovery.whole() ? ", nothing was lost" : "");
  if (!recovery.whole()) throw ExitCode{3};
}

}  // namespace

void add_replay_recover(app::Command replay) {
  app::Command command =
      replay.add_subcommand("recover", "Writes a whole log from a damaged or unfinished one");
  auto settings = std::make_shared<RecoverSettings>();
  command.add_option("F", settings->file, "The damaged log").required();
  command.add_option("--out", settings->out, "The log to write").required();
  command.add_option("--json", settings->json, "Write what was read and lost to this file");
  command.footer(
      "Exit code 0: nothing was lost; 3: something was; 1: nothing could be read.\n"
      "Example: seam replay recover damaged.mcap --out whole.mcap");
  command.callback([settings] { recover(*settings); });
}

}  // namespace seam::tools
