// Lines that behaviours printed, in a log: messages of topic /printed (foxglove.Log), so that other
// MCAP tools show them. No re-run can make them again, and no fingerprint depends on them.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "scheduler/log/log.h"

namespace seam::scheduler {

struct PrintedLine {
  SimTime time;  // Of the observation that the robot was answering.
  std::string robot;
  std::string text;  // UTF-8, without the line's end; control characters shown.
};

std::string encode(const PrintedLine& line);

// Walks over a log's printed lines in the order of time.
class PrintedCursor {
 public:
  // `log` must outlive the cursor.
  explicit PrintedCursor(const Log& log);
  // Nothing at the end; throws InputError at damage.
  std::optional<PrintedLine> next();

 private:
  MessageCursor messages_;
  std::set<uint16_t> channels_;
};

}  // namespace seam::scheduler
