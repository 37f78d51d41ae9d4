// The subcommands of `seam`: one file each, which adds itself to the command line with its help,
// flags and examples. A command throws UsageError (exit code 2) or InputError (exit code 1).
#pragma once

#include "app/command_line.h"

namespace seam::tools {

// One line a command; a file of tools/commands/, tools/network/, tools/open_r/, tools/replay/,
// tools/robots/, tools/sweep/, tools/viewer/ or tools/workbench/ defines add_<name>.
#define SEAM_COMMANDS(X) \
  X(add)                 \
  X(camera_calibrate)    \
  X(certs)               \
  X(check)               \
  X(colour_table)        \
  X(compare)             \
  X(contact_sheet)       \
  X(diagnose)            \
  X(diff)                \
  X(discover)            \
  X(effects)             \
  X(experiment)          \
  X(export)              \
  X(fit)                 \
  X(frame)               \
  X(history)             \
  X(import)              \
  X(joints)              \
  X(measure)             \
  X(new_effect)          \
  X(open_r)              \
  X(plan)                \
  X(replay)              \
  X(report)              \
  X(run)                 \
  X(schema)              \
  X(serve)               \
  X(study)               \
  X(sweep)               \
  X(view)                \
  X(workbench)

#define SEAM_DECLARE(name) void add_##name(app::Command app);
SEAM_COMMANDS(SEAM_DECLARE)
#undef SEAM_DECLARE

// A command that did its work and has a result that its exit code carries (1: a divergence was
// found, 3: recovered with losses) throws this instead of calling exit.
struct ExitCode {
  int code;
};

}  // namespace seam::tools
