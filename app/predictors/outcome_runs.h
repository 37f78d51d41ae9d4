// Runs for sets of kind `outcomes`, by the engine of sweeps: in worker processes, some at a time,
// kept in results files where a folder for them is given, so that a command that was interrupted
// goes on and parts may be made on other machines (docs/reference/outcomes.md).
#pragma once

#include <filesystem>

#include "measurement/imaging/instruments.h"

namespace seam::app {

struct OutcomeRunsOptions {
  std::filesystem::path kept;  // Folder of results files; empty: nothing is kept.
  bool run_programs = false;   // Programs of others, which a set names, may be started.
};

// Must be called while the process has one thread: a helper process is forked, from which the
// workers come.
measurement::OpenRuns outcome_runs(const OutcomeRunsOptions& options);

}  // namespace seam::app
