// What behaviours print, to stdout and stderr alike: whole lines, each with its robot and the
// simulated time. While a robot decides time stands still, so a line that it prints before it
// answers has the time of the observation that it answers, in every run.
#pragma once

#include <array>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "scheduler/log/recorder.h"

namespace seam::app {

// On stderr, in place of the line of progress.
void show_line(const std::string& line);

class PrintedOutput {
 public:
  // A longer line is cut here.
  static constexpr size_t kMostLineBytes = 2048;
  // What a robot may print in a simulated second; a flood beyond it is counted and left out.
  static constexpr size_t kBytesPerSecond = 16 << 10;
  // Lines that are kept of each robot for whoever asks why a run failed.
  static constexpr size_t kLastLines = 50;

  // `now`: the simulated time, from any thread. `shown`: lines go to stderr as they come.
  PrintedOutput(std::function<SimTime()> now, bool shown);
  ~PrintedOutput();
  PrintedOutput(const PrintedOutput&) = delete;
  PrintedOutput& operator=(const PrintedOutput&) = delete;

  // Where a robot's processes are to write; the caller closes it once they have it.
  int open(const std::string& robot);
  // From now on the pipes of all that were opened are emptied as they fill.
  void start();
  // The lines that came since the last call, by robot in the order of `open`, with this time; all
  // that the pipes hold is read first. Where lines were left out and none since the last call, or
  // at the end, their number is a line.
  std::vector<scheduler::PrintedLine> take(SimTime time, bool at_end = false);
  // The last lines of all robots as they were shown, a robot's after another's.
  std::vector<std::string> last_lines() const;

 private:
  struct Source {
    std::string robot;
    int pipe = -1;
    std::string begun;                 // A line without its end.
    std::vector<std::string> waiting;  // For `take`.
    std::deque<std::string> last;
    SimTime budget_at;
    double budget_bytes = kBytesPerSecond;
    uint64_t left_out = 0;  // Lines, since one was shown.
    bool floods = false;    // Some of them since the last call of `take`.
  };

  void read(Source& source);
  void end_line(Source& source);
  void show(Source& source, SimTime time, std::string text);
  void show_left_out(Source& source, SimTime time);
  void watch();

  const std::function<SimTime()> now_;
  const bool shown_;
  mutable std::mutex mutex_;
  std::deque<Source> sources_;
  std::array<int, 2> wake_{-1, -1};  // A pipe that ends the thread.
  std::jthread thread_;
};

// Hands what was printed before a turn to the log, in front of it.
class Printing final : public scheduler::SimulationObserver {
 public:
  // `recorder`: null where there is no log.
  Printing(PrintedOutput& output, scheduler::Recorder* recorder)
      : output_(output), recorder_(recorder) {}
  void on_turn(SimTime time, const scheduler::Turn&) override { pass_on(time); }
  void on_end(SimTime time, scheduler::EndReason, uint64_t) override { pass_on(time, true); }

 private:
  void pass_on(SimTime time, bool at_end = false);

  PrintedOutput& output_;
  scheduler::Recorder* recorder_;
};

}  // namespace seam::app
