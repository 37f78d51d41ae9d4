// What of the robots' orders did not act as ordered: decisions that were refused, targets that were
// clamped. A program may make the same mistake at each of its turns: each is reported once and
// counted.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "scheduler/loop/observer.h"

namespace seam::scheduler {

// Faults of these names in a run's events.
inline constexpr const char* kRefusedFault = "refused";
inline constexpr const char* kClampedFault = "clamped";

class CommandNotes final : public SimulationObserver {
 public:
  struct Refused {
    uint64_t count = 0;
    SimTime first;
    std::string why;  // Of the first.
  };

  void on_event(const SimulationEvent& event) override;
  void on_turn(SimTime time, const Turn& turn) override;
  void on_start(const RunHeader& header) override { robots_ = header.robots; }

  // By the robot's id.
  const std::map<std::string, Refused>& refused() const { return refused_; }
  // As they were reported at their times.
  const std::vector<std::string>& clamped_lines() const { return clamped_; }
  // For people, one line a robot: "red1: 62 of 80 decisions were refused and did nothing; the first
  // at 0.120 s: ...".
  std::vector<std::string> refused_lines() const;

 private:
  std::vector<std::string> robots_;
  std::map<std::string, Refused> refused_;
  std::map<std::string, uint64_t> decisions_;
  std::vector<std::string> clamped_;
};

// "0.120 s red1: warning: pan: 90 rad is out of its range ...".
std::string clamped_line(const SimulationEvent& event);

}  // namespace seam::scheduler
