#include "app/terminal_progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sim_core/input/shown_text.h"
#include "sim_core/system/thread.h"

namespace seam::app {
namespace {

constexpr auto kEach = std::chrono::seconds(1);
constexpr const char* kClear = "\r\033[K";

double seconds(std::chrono::steady_clock::duration span) {
  return std::chrono::duration<double>(span).count();
}

}  // namespace

std::string duration_text(double seconds) {
  const auto whole = static_cast<long long>(std::ceil(seconds));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

TerminalProgress::TerminalProgress() : terminal_(isatty(STDERR_FILENO) != 0) {
  if (!terminal_) return;
  watch_work(&tally_);
  say_work("reading the set");
  thread_ = start_thread([this] {
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, kEach, [&] { return ending_; })) show();
    std::fputs(kClear, stderr);
  });
}

TerminalProgress::~TerminalProgress() {
  if (!terminal_) return;
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
  watch_work(nullptr);
}

void TerminalProgress::print_between(const std::string& text) {
  const std::lock_guard lock(mutex_);
  if (terminal_) std::fputs(kClear, stderr);
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
}

void TerminalProgress::show() {
  const WorkTally::Seen seen = tally_.seen();
  const Clock::time_point now = Clock::now();
  if (seen.number != part_) part_ = seen.number, part_start_ = now;
  std::string line =
      fmt::format("{}{} {}", kClear, duration_text(seconds(now - start_)), shown(seen.label));
  if (!seen.part.empty()) {
    line += fmt::format(": {} {} of {}{}", seen.part, seen.done, seen.at_most ? "at most " : "",
                        seen.of);
    const double spent = seconds(now - part_start_);
    if (seen.done > 0 && spent > 1)
      line +=
          fmt::format(", {}{} left", seen.at_most ? "at most " : "about ",
                      duration_text(spent / static_cast<double>(seen.done) *
                                    static_cast<double>(seen.of - std::min(seen.of, seen.done))));
  }
  line += fmt::format(" ({} steps of fits)", seen.steps);
  std::fputs(line.c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace seam::app
