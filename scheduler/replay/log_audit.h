// What of a log can be wrong without any re-run noticing: copies that differ from what they copy,
// times of messages, the index, and what came from outside, by its hash.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scheduler/log/log.h"
#include "scheduler/replay/divergence.h"

namespace seam::scheduler {

struct LogAudit {
  std::optional<Divergence> finding;
  // What nothing proves: sentences for people.
  std::vector<std::string> unproved;
};

// `log` must be open with LogAccess::scanned: by the index alone a misleading one is not noticed.
LogAudit audit(const Log& log);

}  // namespace seam::scheduler
