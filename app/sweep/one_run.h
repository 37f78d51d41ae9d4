// One run of a plan, from its number to its record.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "app/session/standbys.h"
#include "app/sweep/makers.h"
#include "app/sweep/plan/plan.h"
#include "app/sweep/results.h"

namespace seam::app {

struct OneRunOptions {
  std::filesystem::path files;  // Where logs and frames go, if the plan keeps them.
  int render_workers = 1;
  Standbys* standbys = nullptr;              // Behaviours of the process's runs.
  std::function<void(Scenario&)> move = {};  // To where its files are here; none: they are there.
};

// Where the log of a run grows until the run is finished.
std::filesystem::path partial_log(const std::filesystem::path& files, uint64_t run);

// Never throws for what a run's own settings bring about: the record then says what went wrong.
// `end` is `stopped` where a signal ended it, and then there is nothing to keep.
RunRecord make_run(const SweepPlan& plan, uint64_t run, const Makers& makers, ProgramPrints& prints,
                   const OneRunOptions& options);

// A record as a text, to be sent from one process to another.
std::string to_text(const RunRecord& record);
RunRecord record_from_text(const std::string& text);

}  // namespace seam::app
