// The command line of `seam serve --dm-env-rpc`, as the kind of its worlds.
#pragma once

#include <string>

#include "app/session/run_session.h"
#include "tools/dm_env_rpc/worlds.h"

namespace seam::tools::dm {

struct LearningOptions {
  bool asked = false;  // --dm-env-rpc
  int worlds = 8;
  std::string logs;
};

// Reads the scenario. Throws InputError, UsageError for options that a run of its own needs, and
// makes the folder of logs.
WorldKind make_world_kind(const std::string& scenario, const app::SessionOptions& session,
                          const app::SimulatorOptions& simulator, const LearningOptions& learning);

}  // namespace seam::tools::dm
