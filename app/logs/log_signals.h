// What a log holds as numbers over time, by the names of app/signals/record_signals.h; truth in the
// steps that the log keeps.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scheduler/log/log.h"

namespace seam::app {

// One number of a name, in the order of time.
struct SignalSample {
  SimTime time;
  uint32_t name = 0;  // Its place in the names asked for.
  double value = 0;
};

struct LogSignals {
  std::vector<SignalSample> samples;
  SimTime end;
};

// Of these names. Throws UsageError for a name that the log does not have, with the nearest one.
// Joints that the log does not keep are worked out by running its world again.
LogSignals read_signals(const scheduler::Log& log, const std::vector<std::string>& names);

// All names of a log, sorted.
std::vector<std::string> signal_names(const scheduler::Log& log);

}  // namespace seam::app
