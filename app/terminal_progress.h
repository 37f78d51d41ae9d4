// One line on a terminal, renewed each second, for computations that count their work
// (sim_core/system/work_tally.h): what is done, of how many, and the time left. Silent elsewhere.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "sim_core/system/work_tally.h"

namespace seam::app {

// "1 h 05 min", "3 min 20 s", "12 s".
std::string duration_text(double seconds);

// "12 s step 2: trying effects: candidates 3 of at most 9, at most 8 s left (40 steps of fits)",
// total_s after the start of all and part_s after that of the part. Time left is estimated from a
// second of the part on.
std::string progress_text(const WorkTally::Seen& seen, double total_s, double part_s);

class TerminalProgress {
 public:
  TerminalProgress();
  ~TerminalProgress();
  TerminalProgress(const TerminalProgress&) = delete;
  TerminalProgress& operator=(const TerminalProgress&) = delete;

  // Clears the line while something else is printed.
  void print_between(const std::string& text);

 private:
  using Clock = std::chrono::steady_clock;

  void show();

  WorkTally tally_;
  bool terminal_;
  Clock::time_point start_ = Clock::now(), part_start_ = start_;
  uint64_t part_ = 0;  // The last that was seen.
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ending_ = false;
  std::jthread thread_;
};

}  // namespace seam::app
