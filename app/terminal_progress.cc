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

std::string progress_text(const WorkTally::Seen& seen, double total_s, double part_s) {
  std::string line = fmt::format("{} {}", duration_text(total_s), shown(seen.label));
  if (!seen.part.empty()) {
    const char* at_most = seen.at_most ? "at most " : "";
    line += fmt::format(": {} {} of {}{}", seen.part, seen.done, at_most, seen.of);
    const auto left = static_cast<double>(seen.of - std::min(seen.of, seen.done));
    if (seen.done > 0 && part_s > 1)
      line += fmt::format(", {}{} left", seen.at_most ? at_most : "about ",
                          duration_text(part_s / static_cast<double>(seen.done) * left));
  }
  return line + fmt::format(" ({} steps of fits)", seen.steps);
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
  std::fputs(
      (kClear + progress_text(seen, seconds(now - start_), seconds(now - part_start_))).c_str(),
      stderr);
  std::fflush(stderr);
}

}  // namespace seam::app
