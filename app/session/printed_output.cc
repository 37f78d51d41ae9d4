#include "app/session/printed_output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"
#include "sim_core/system/thread.h"

namespace seam::app {

void show_line(const std::string& line) {
  // The line of progress stands where the cursor is.
  fmt::print(stderr, "{}{}\n", isatty(STDERR_FILENO) ? "\r\033[K" : "", line);
}

PrintedOutput::PrintedOutput(std::function<SimTime()> now, bool shown)
    : now_(std::move(now)), shown_(shown) {}

PrintedOutput::~PrintedOutput() {
  if (thread_.joinable()) {
    close(wake_[1]);
    thread_.join();
    close(wake_[0]);
  }
  for (const Source& source : sources_)
    if (source.pipe >= 0) close(source.pipe);
}

int PrintedOutput::open(const std::string& robot) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw InputError(fmt::format("robot '{}': no pipe for what its behaviour prints", robot));
  fcntl(ends[0], F_SETFL, O_NONBLOCK);
  const std::lock_guard lock(mutex_);
  sources_.push_back({.robot = robot, .pipe = ends[0], .budget_at = now_()});
  return ends[1];
}

void PrintedOutput::start() {
  if (pipe2(wake_.data(), O_CLOEXEC) != 0) throw InputError("no pipe for what behaviours print");
  thread_ = start_thread([this] { watch(); });
}

// Empties the pipes, so that nobody waits for room to print, also while a robot decides.
void PrintedOutput::watch() {
  while (true) {
    std::vector<pollfd> waiting = {{wake_[0], POLLIN, 0}};
    {
      const std::lock_guard lock(mutex_);
      for (const Source& source : sources_)
        if (source.pipe >= 0) waiting.push_back({source.pipe, POLLIN, 0});
    }
    poll(waiting.data(), waiting.size(), -1);
    if (waiting[0].revents != 0) return;
    const std::lock_guard lock(mutex_);
    for (Source& source : sources_) read(source);
  }
}

void PrintedOutput::read(Source& source) {
  std::array<char, 1 << 14> buffer;
  // A flood leaves others their turn.
  for (int i = 0; i < 16 && source.pipe >= 0; ++i) {
    const ssize_t size = ::read(source.pipe, buffer.data(), buffer.size());
    if (size < 0) return;  // Nothing there now.
    if (size == 0) {       // All that had it have ended.
      if (!source.begun.empty()) end_line(source);
      close(std::exchange(source.pipe, -1));
      return;
    }
    for (const char byte : std::string_view(buffer.data(), static_cast<size_t>(size))) {
      if (byte == '\n') {
        end_line(source);
      } else if (source.begun.size() <= kMostLineBytes) {
        source.begun.push_back(byte);
      }
    }
  }
}

void PrintedOutput::end_line(Source& source) {
  std::string text = std::exchange(source.begun, {});
  if (text.ends_with('\r')) text.pop_back();
  if (text.size() > kMostLineBytes) {
    text.resize(kMostLineBytes);
    text += " ...";
  }
  const SimTime time = now_();
  constexpr double kMost = kBytesPerSecond;
  source.budget_bytes =
      std::min(kMost, source.budget_bytes + kMost * (time - source.budget_at).s());
  source.budget_at = time;
  const auto bytes = static_cast<double>(text.size() + 1);
  if (bytes > source.budget_bytes) {
    ++source.left_out;
    source.floods = true;
    return;
  }
  source.budget_bytes -= bytes;
  show_left_out(source, time);
  show(source, time, shown(text));
}

void PrintedOutput::show_left_out(Source& source, SimTime time) {
  if (source.left_out > 0)
    show(source, time,
         fmt::format("({} lines left out: more than {} bytes a simulated second)",
                     std::exchange(source.left_out, 0), kBytesPerSecond));
}

void PrintedOutput::show(Source& source, SimTime time, std::string text) {
  const std::string line = fmt::format("{:.3f} s {}: {}", time.s(), source.robot, text);
  if (shown_) show_line(line);
  source.last.push_back(line);
  if (source.last.size() > kLastLines) source.last.pop_front();
  source.waiting.push_back(std::move(text));
}

std::vector<scheduler::PrintedLine> PrintedOutput::take(SimTime time, bool at_end) {
  const std::lock_guard lock(mutex_);
  std::vector<scheduler::PrintedLine> lines;
  for (Source& source : sources_) {
    read(source);
    if (!std::exchange(source.floods, false) || at_end) show_left_out(source, now_());
    for (std::string& text : std::exchange(source.waiting, {}))
      lines.push_back({time, source.robot, std::move(text)});
  }
  return lines;
}

std::vector<std::string> PrintedOutput::last_lines() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> lines;
  for (const Source& source : sources_) {
    lines.insert(lines.end(), source.last.begin(), source.last.end());
    if (source.left_out > 0)
      lines.push_back(fmt::format("{}: ({} lines left out)", source.robot, source.left_out));
  }
  return lines;
}

void Printing::pass_on(SimTime time, bool at_end) {
  for (const scheduler::PrintedLine& line : output_.take(time, at_end))
    if (recorder_ != nullptr) recorder_->note_printed(line);
}

}  // namespace seam::app
