// `seam replay diff A B`, also `seam diff A B`: where two runs first differ, and how that spreads.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/logs/log_difference.h"
#include "app/logs/replay_match.h"
#include "scheduler/replay/log_diff.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "tools/command.h"
#include "tools/replay/replay.h"

namespace seam::tools {
namespace {

struct DiffSettings {
  std::string a;
  std::string b;
  std::string json;
};

void tell_difference(const DiffSettings& settings) {
  OutputFile json(settings.json, {.inputs = {settings.a, settings.b}});
  const scheduler::Log a = scheduler::Log::open(settings.a);
  const scheduler::Log b = scheduler::Log::open(settings.b);
  const scheduler::LogDifference difference = app::difference_of(a, b);
  if (json) json.fill(app::to_json(difference) + "\n");
  std::fputs(app::to_text(difference).c_str(), stdout);
  if (!difference.equal()) throw ExitCode{1};
}

void add(app::Command parent) {
  app::Command command = parent.add_subcommand(
      "diff", "The first difference of two runs by time, section and field, and how it spreads");
  auto settings = std::make_shared<DiffSettings>();
  command.add_option("A", settings->a, "A log").required();
  command.add_option("B", settings->b, "Another log").required();
  command.add_option("--json", settings->json, "Write the result as seam-diff/1 to this file");
  command.footer("Exit code 0: equal; 1: they differ.\nExample: seam diff monday.mcap today.mcap");
  command.callback([settings] { tell_difference(*settings); });
}

}  // namespace

void add_replay_diff(app::Command replay) {
  add(replay);
}
void add_diff(app::Command app) {
  add(app);
}

}  // namespace seam::tools
