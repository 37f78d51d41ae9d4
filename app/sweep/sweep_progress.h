// One line on a terminal: runs (or what else is counted) done, failed, a second, and the time left.
// Silent elsewhere.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "app/terminal_progress.h"

namespace seam::app {

// Time on the wall since it was made.
class Stopwatch {
 public:
  double s() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

class SweepProgress {
 public:
  explicit SweepProgress(uint64_t total, const char* what = "runs");
  ~SweepProgress();
  SweepProgress(const SweepProgress&) = delete;
  SweepProgress& operator=(const SweepProgress&) = delete;

  void count(bool failed);
  void show() const;

 private:
  uint64_t total_, done_ = 0, failed_ = 0;
  const char* what_;
  bool terminal_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace seam::app
