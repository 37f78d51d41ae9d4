// How far a command is, line by line on its standard output, for a program that started it and
// reads them: {"event": "work", "doing": "planning: effects planned", "done": 3, "of": 9}.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "sim_core/system/work_tally.h"

namespace seam::tools {

// Set for a command whose lines are wanted.
inline constexpr const char* kWorkLines = "SEAM_WORK_LINES";

// Without the line's end. Of a part that is not counted `of` is 0.
std::string work_line(const WorkTally::Seen& seen);

// Silent where they are not wanted.
class WorkLines {
 public:
  WorkLines();
  ~WorkLines();
  WorkLines(const WorkLines&) = delete;
  WorkLines& operator=(const WorkLines&) = delete;

 private:
  const bool wanted_;
  WorkTally tally_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ending_ = false;
  std::jthread thread_;
};

}  // namespace seam::tools
