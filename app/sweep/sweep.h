// Makes the runs of a plan that results lack, some at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "app/sweep/makers.h"
#include "app/sweep/plan/plan.h"
#include "app/sweep/results.h"

namespace seam::app {

struct SweepOutcome {
  uint64_t made = 0;    // Now.
  uint64_t failed = 0;  // Of them.
  bool interrupted = false;
};

// The folder beside results where their runs' logs and frames are kept.
std::filesystem::path run_files(const std::filesystem::path& results);

// Each record comes to `done` in the order in which runs end, on this thread, which must be the
// process's only one. `jobs` 0: one for each core. `prints`: those that are known. `move`: changes
// each scenario before its run, where files are elsewhere than it says.
SweepOutcome make_runs(const SweepPlan& plan, const std::vector<uint64_t>& runs,
                       const Makers& makers, int jobs, const std::filesystem::path& files,
                       const std::function<void(const RunRecord&)>& done, ProgramPrints prints = {},
                       std::function<void(Scenario&)> move = {});

// The runs of the file's shard that are not finished, with failed ones among them, into the file.
SweepOutcome make_missing_runs(ResultsFile& results, int jobs, ProgramPrints prints = {});

}  // namespace seam::app
