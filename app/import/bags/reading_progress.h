// How far the reading of long files is, on a terminal and for who watches.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "sim_core/system/work_tally.h"

namespace seam::app {

class ReadingProgress {
 public:
  // `all` is what will be read, in bytes or in pieces; shown in units of `unit_size`.
  ReadingProgress(std::string source, uint64_t all, const char* unit = "MB",
                  double unit_size = 1e6);
  ~ReadingProgress();
  ReadingProgress(const ReadingProgress&) = delete;
  ReadingProgress& operator=(const ReadingProgress&) = delete;

  // Silent for the first two seconds, then a line that is renewed twice a second. Nothing where
  // stderr is no terminal.
  void at(uint64_t done);

 private:
  std::string source_;
  uint64_t all_;
  const char* unit_;
  double unit_size_;
  Work work_;
  bool terminal_, shown_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), next_;
};

}  // namespace seam::app
