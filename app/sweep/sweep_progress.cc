#include "app/sweep/sweep_progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace seam::app {

SweepProgress::SweepProgress(uint64_t total, const char* what)
    : total_(total), what_(what), terminal_(isatty(STDERR_FILENO) != 0) {}

SweepProgress::~SweepProgress() {
  if (terminal_) std::fputs("\r\033[K", stderr);
}

void SweepProgress::count(bool failed) {
  ++done_;
  failed_ += failed ? 1 : 0;
}

void SweepProgress::show() const {
  if (!terminal_) return;
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start_;
  std::string line = fmt::format("\r\033[K{} of {} {}", done_, total_, what_);
  if (failed_ > 0) line += fmt::format(", {} failed", failed_);
  if (done_ > 0) {
    const double each_s = wall.count() / static_cast<double>(done_);
    line += fmt::format("   {:.1f} a second   {} left", 1 / each_s,
                        duration_text(each_s * static_cast<double>(total_ - done_)));
  }
  std::fputs(line.c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace seam::app
