#include "app/sweep/sweep.h"

#include <algorithm>
#include <set>

#include "app/sweep/one_run.h"
#include "app/sweep/sweep_progress.h"
#include "app/sweep/workers.h"
#include "sim_core/base/output.h"

namespace seam::app {

namespace fs = std::filesystem;

fs::path run_files(const fs::path& results) {
  return results.string() + ".files";
}

SweepOutcome make_runs(const SweepPlan& plan, const std::vector<uint64_t>& runs,
                       const Makers& makers, int jobs, const fs::path& files,
                       const std::function<void(const RunRecord&)>& done, ProgramPrints prints) {
  const int workers = jobs > 0 ? jobs : machine_cores();
  Standbys standbys;  // Each worker fills its own copy.
  const OneRunOptions options{
      .files = files, .render_workers = cores_for_each(workers), .standbys = &standbys};
  if (!runs.empty() && (plan.keep().logs || plan.keep().frames)) make_output_folder(files);
  SweepOutcome outcome;
  SweepProgress progress(runs.size());
  size_t next = 0;
  std::set<uint64_t> begun;
  const auto take = [&](const RunRecord& record) {
    ++outcome.made;
    begun.erase(record.run);
    outcome.failed += record.failed() ? 1 : 0;
    progress.count(record.failed());
    done(record);
  };
  const WorkerCalls calls{
      .next = [&]() -> std::optional<uint64_t> {
        if (next == runs.size()) return std::nullopt;
        begun.insert(runs[next]);
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
  // Of processes that were killed since they did not end in time.
  std::error_code unknown;
  for (const uint64_t run : begun) fs::remove(partial_log(files, run), unknown);
  return outcome;
}

SweepOutcome make_missing_runs(ResultsFile& results, int jobs, ProgramPrints prints) {
  const std::vector<bool> finished = results.finished();
  std::vector<uint64_t> runs;
  for (uint64_t run = 0; run < finished.size(); ++run) {
    if (!finished[run] && results.shard().has(run)) runs.push_back(run);
  }
  return make_runs(
      results.plan(), runs, results.makers(), jobs, run_files(results.path()),
      [&](const RunRecord& record) { results.add(record); }, std::move(prints));
}

}  // namespace seam::app
