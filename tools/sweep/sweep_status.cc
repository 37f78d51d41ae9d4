// `seam sweep status`: how far a sweep is, also while it runs.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/sweep/results.h"
#include "app/sweep/sweep_progress.h"
#include "sim_core/base/output.h"
#include "sim_core/input/shown_text.h"
#include "tools/sweep/sweep.h"

namespace seam::tools {
namespace {

constexpr size_t kShownErrors = 5;

struct Failure {
  uint64_t run;
  std::string error;
};

std::vector<Failure> failures_of(const app::ResultsFile& results) {
  std::vector<Failure> failures;
  results.each([&](const app::RunRecord& record) {
    if (record.failed()) failures.push_back({record.run, record.error});
  });
  return failures;
}

std::string status_json(const app::ResultsFile& results, const app::SweepCounts& counts,
                        const std::vector<Failure>& failures) {
  nlohmann::ordered_json json = {{"format", "seam-sweep-status/1"},
                                 {"plan", results.plan().texts().name},
                                 {"runs", results.plan().runs()},
                                 {"shard", to_string(results.shard())},
                                 {"planned", counts.planned},
                                 {"finished", counts.finished},
                                 {"failed", counts.failed},
                                 {"wall_s", counts.wall_s},
                                 {"version", results.makers().version},
                                 {"program", results.makers().program},
                                 {"behaviours", results.makers().behaviours}};
  json["failures"] = nlohmann::ordered_json::array();
  for (const Failure& failure : failures)
    json["failures"].push_back({{"run", failure.run}, {"error", failure.error}});
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void status(const std::string& file, const std::string& json_file) {
  OutputFile json(json_file, {.inputs = {file}});
  const auto results = app::ResultsFile::for_reading(file);
  const app::SweepCounts counts = results.counts();
  const std::vector<Failure> failures = failures_of(results);
  std::string text = fmt::format("{}: {} of {} runs are finished, {} failed\n", file,
                                 counts.finished, counts.planned, counts.failed);
  text += fmt::format("  plan         {}, {} runs{}\n", results.plan().texts().name,
                      results.plan().runs(),
                      results.shard() == app::Shard{}
                          ? ""
                          : fmt::format(", of which this is shard {}", to_string(results.shard())));
  text += fmt::format("  made by      SEAM {} ({}), behaviours {}\n", results.makers().version,
                      results.makers().program, results.makers().behaviours);
  const uint64_t left = counts.planned - counts.finished;
  if (counts.finished > 0) {
    const double each_s = counts.wall_s / static_cast<double>(counts.finished + counts.failed);
    text += fmt::format("  time         {:.3g} s a run", each_s);
    if (left > 0)
      text += fmt::format("; {} of runs left, one after the other",
                          app::duration_text(each_s * static_cast<double>(left)));
    text += "\n";
  }
  for (size_t i = 0; i < std::min(kShownErrors, failures.size()); ++i)
    text += fmt::format("  run {} failed: {}\n", failures[i].run, failures[i].error);
  if (failures.size() > kShownErrors)
    text += fmt::format("  and {} more (--json)\n", failures.size() - kShownErrors);
  std::fputs(shown_lines(text).c_str(), stdout);
  if (json) json.fill(status_json(results, counts, failures));
}

}  // namespace

void add_sweep_status(app::Command sweep) {
  app::Command command = sweep.add_subcommand(
      "status", "How many runs are finished and failed, and why; also while the sweep runs");
  auto file = std::make_shared<std::string>();
  auto json = std::make_shared<std::string>();
  command.add_option("RESULTS", *file, "A file that `seam sweep` made").required();
  command.add_option("--json", *json, "Writes the same here");
  command.footer("Example: seam sweep status results.sqlite");
  command.callback([file, json] { status(*file, *json); });
}

}  // namespace seam::tools
