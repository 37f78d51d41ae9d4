// `seam sweep ...`: one file a subcommand.
#pragma once

#include "app/command_line.h"

namespace seam::tools {

#define SEAM_SWEEP_COMMANDS(X) \
  X(bundle)                    \
  X(merge)                     \
  X(plot)                      \
  X(rerun)                     \
  X(status)                    \
  X(submit)                    \
  X(table)

#define SEAM_DECLARE(name) void add_sweep_##name(app::Command sweep);
SEAM_SWEEP_COMMANDS(SEAM_DECLARE)
#undef SEAM_DECLARE

}  // namespace seam::tools
