#include "app/session/progress.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cstdio>

#include "sim_core/system/thread.h"

namespace seam::app {

Progress::Progress(const scheduler::ClientHub& hub, const scheduler::RunControl& control,
                   SimDuration total)
    : hub_(hub), control_(control), total_(total), terminal_(isatty(STDERR_FILENO) != 0) {
  thread_ = start_thread([this] {
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, std::chrono::milliseconds(200), [&] { return ending_; })) {
      if (terminal_)
        show();
      else
        warn_of_silence();
    }
    if (terminal_) std::fputs("\r\033[K", stderr);
  });
}

Progress::~Progress() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Progress::show() {
  const double sim_s = control_.time().s();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start_;
  double since_s = 0;
  const auto waiting = hub_.waiting_for(since_s);
  std::string line = fmt::format("\r\033[K{:8.2f} of {:.2f} s   {:.1f} x real time", sim_s,
                                 total_.s(), sim_s / wall.count());
  if (control_.paused()) line += "   paused";
  if (since_s > 0.3)
    line += fmt::format("   waiting for {} ({:.1f} s)", fmt::join(waiting, ", "), since_s);
  std::fputs(line.c_str(), stderr);
  std::fflush(stderr);
}

void Progress::warn_of_silence() {
  double since_s = 0;
  const auto waiting = hub_.waiting_for(since_s);
  if (since_s < 5) {
    warned_ = false;
  } else if (!warned_) {
    warned_ = true;
    const std::string line = fmt::format(
        "waiting for {} at {:.3f} s: no decision for {:.0f} s (in the scenario, "
        "behaviour: {{silence: abort, wall_limit_s: N}} ends such a run)\n",
        fmt::join(waiting, ", "), control_.time().s(), since_s);
    std::fputs(line.c_str(), stderr);
  }
}

}  // namespace seam::app
