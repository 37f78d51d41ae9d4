#include "app/import/bags/reading_progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

#include "sim_core/input/shown_text.h"

namespace seam::app {

using std::chrono::steady_clock;

ReadingProgress::ReadingProgress(std::string source, uint64_t all, const char* unit,
                                 double unit_size)
    : source_(std::move(source)),
      all_(all),
      unit_(unit),
      unit_size_(unit_size),
      work_(unit, static_cast<size_t>(static_cast<double>(all) / unit_size)),
      terminal_(isatty(STDERR_FILENO) != 0),
      next_(start_ + std::chrono::seconds(2)) {}

ReadingProgress::~ReadingProgress() {
  if (shown_) std::fputs("\r\x1b[K", stderr);
}

void ReadingProgress::at(uint64_t done) {
  work_.done_so_far(static_cast<uint64_t>(static_cast<double>(done) / unit_size_));
  if (!terminal_ || all_ == 0) return;
  const auto now = steady_clock::now();
  if (now < next_) return;
  next_ = now + std::chrono::milliseconds(500);
  shown_ = true;
  const double spent_s = std::chrono::duration<double>(now - start_).count();
  const double part = static_cast<double>(done) / static_cast<double>(all_);
  const double left_s = part > 0 ? spent_s * (1 - part) / part : 0;
  std::fputs(fmt::format("\r\x1b[K{}: {:.0f} of {:.0f} {} read, {:.0f} s left", shown(source_),
                         static_cast<double>(done) / unit_size_,
                         static_cast<double>(all_) / unit_size_, unit_, left_s)
                 .c_str(),
             stderr);
  std::fflush(stderr);
}

}  // namespace seam::app
