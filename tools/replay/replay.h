// The subcommands of `seam replay`: `tools/replay_<name>.cc` defines add_replay_<name>.
#pragma once

#include "app/command_line.h"

namespace seam::tools {

#define SEAM_REPLAY_COMMANDS(X) \
  X(verify) X(show) X(diff) X(export) X(recover) X(frames) X(resume) X(whatif) X(accuracy)

#define SEAM_DECLARE(name) void add_replay_##name(app::Command replay);
SEAM_REPLAY_COMMANDS(SEAM_DECLARE)
#undef SEAM_DECLARE

}  // namespace seam::tools
