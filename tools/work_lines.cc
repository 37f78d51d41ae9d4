#include "tools/work_lines.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "sim_core/system/thread.h"

namespace seam::tools {
namespace {

constexpr auto kLineEach =
    std::chrono::milliseconds(100);  // A bar that moves smoothly needs no more.

}  // namespace

std::string work_line(const WorkTally::Seen& seen) {
  const bool counted = !seen.part.empty();
  const std::string between = counted && !seen.label.empty() ? ": " : "";
  return nlohmann::json{{"event", "work"},
                        {"doing", seen.label + between + seen.part},
                        {"done", counted ? seen.done : 0},
                        {"of", counted ? seen.of : 0}}
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

WorkLines::WorkLines() : wanted_(std::getenv(kWorkLines) != nullptr) {
  if (!wanted_) return;
  ::unsetenv(kWorkLines);  // Programs that the command starts write other things there.
  watch_work(&tally_);
  thread_ = start_thread([this] {
    std::string last = work_line({});
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, kLineEach, [&] { return ending_; })) {
      std::string line = work_line(tally_.seen());
      if (line == last) continue;
      std::printf("%s\n", line.c_str());
      std::fflush(stdout);
      last = std::move(line);
    }
  });
}

WorkLines::~WorkLines() {
  if (!wanted_) return;
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
  watch_work(nullptr);
}

}  // namespace seam::tools
