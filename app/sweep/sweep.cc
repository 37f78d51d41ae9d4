#include "app/sweep/sweep.h"

#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <set>

#include "app/sweep/one_run.h"
#include "app/sweep/sweep_progress.h"
#include "app/sweep/workers.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"

namespace seam::app {

namespace fs = std::filesystem;

fs::path run_files(const fs::path& results) {
  return results.string() + ".files";
}

namespace {

// Runs that are being made. Logs of processes that were killed, since they did not end in time, go.
struct Begun {
  const fs::path& files;
  std::set<uint64_t> runs = {};
  ~Begun() {
    std::error_code unknown;
    for (const uint64_t run : runs) fs::remove(partial_log(files, run), unknown);
  }
};

}  // namespace

SweepOutcome make_runs(const SweepPlan& plan, const std::vector<uint64_t>& runs,
                       const Makers& makers, int jobs, const fs::path& files,
                       const std::function<void(const RunRecord&)>& done, ProgramPrints prints,
                       std::function<void(Scenario&)> move) {
  const int workers = jobs > 0 ? jobs : machine_cores();
  Standbys standbys;  // Each worker fills its own copy.
  const OneRunOptions options{.files = files,
                              .render_workers = cores_for_each(workers),
                              .standbys = &standbys,
                              .move = std::move(move)};
  if (!runs.empty() && (plan.keep().logs || plan.keep().frames)) make_output_folder(files);
  SweepOutcome outcome;
  SweepProgress progress(runs.size());
  size_t next = 0;
  Begun begun{files};
  const auto take = [&](const RunRecord& record) {
    ++outcome.made;
    begun.runs.erase(record.run);
    outcome.failed += record.failed() ? 1 : 0;
    progress.count(record.failed());
    done(record);
  };
  const WorkerCalls calls{
      .next = [&]() -> std::optional<uint64_t> {
        if (next == runs.size()) return std::nullopt;
        begun.runs.insert(runs[next]);
        return runs[next++];
      },
      .work =
          [&](uint64_t run) {
            const RunRecord record = make_run(plan, run, makers, prints, options);
            return record.end == "stopped" ? std::string() : to_text(record);
          },
      .done = [&](uint64_t, const std::string& result) { take(record_from_text(result)); },
      .died = [&](uint64_t run,
                  const std::string& how) { take({.run = run, .error = "its process " + how}); },
      .tick = [&] { progress.show(); }};
  const auto most = static_cast<size_t>(workers);
  outcome.interrupted = !run_in_workers(static_cast<int>(std::min(most, runs.size())), calls);
  return outcome;
}

namespace {

// What the first run that went as it should shows for all others: throws where a value of the plan
// is logged by nobody, before hours are spent on an empty column.
void check_first_run(const RunRecord& record) {
  for (const std::string& note : record.notes)
    std::fprintf(stderr, "%srun %llu: %s\n", isatty(STDERR_FILENO) != 0 ? "\r\033[K" : "",
                 static_cast<unsigned long long>(record.run), note.c_str());
  if (!record.unlogged.empty())
    throw InputError(fmt::format("{}", fmt::join(record.unlogged, "\nseam: ")));
}

}  // namespace

SweepOutcome make_missing_runs(ResultsFile& results, int jobs, ProgramPrints prints) {
  const std::vector<bool> finished = results.finished();
  std::vector<uint64_t> runs;
  for (uint64_t run = 0; run < finished.size(); ++run) {
    if (!finished[run] && results.shard().has(run)) runs.push_back(run);
  }
  bool checked = false;
  const auto take = [&](const RunRecord& record) {
    if (!checked && !record.failed()) check_first_run(record);
    checked = checked || !record.failed();
    results.add(record);
  };
  return make_runs(results.plan(), runs, results.makers(), jobs, run_files(results.path()), take,
                   std::move(prints));
}

}  // namespace seam::app
