// Commands and states that stand in two files, joined by time into one log.
#pragma once

#include <string>
#include <vector>

#include "app/import/draft/request.h"
#include "app/import/draft/set_draft.h"
#include "app/import/files/signals.h"

namespace seam::app {

struct ServoLogs {
  std::vector<SignalLog> logs;
  std::vector<std::string> runs;  // What the run of each is called.
  ImportRequest request;          // With the names of quantities in these logs.
};

// The logs as they are where each holds commands and states. Where none does, each log of commands
// is joined with that of the states beside it: a state gets the last command at or before its time.
// Throws InputError where files do not say which is which, or do not overlap.
ServoLogs servo_logs(const ImportRequest& request, SetDraft& draft);

}  // namespace seam::app
