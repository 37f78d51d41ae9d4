// How much memory the process holds, at each tenth simulated second: what distinguishes a leak from
// a run that is merely large.
#pragma once

#include <cstdint>
#include <vector>

#include "scheduler/loop/observer.h"

namespace seam::app {

// Resident memory of this process now; 0 where it is unknown.
uint64_t resident_bytes();

struct MemorySample {
  double sim_s = 0;
  uint64_t resident_bytes = 0;
};

class MemoryWatch final : public scheduler::SimulationObserver {
 public:
  void on_step(SimTime time, uint64_t step, const StateDigest& state) override;

  const std::vector<MemorySample>& samples() const { return samples_; }

 private:
  SimTime next_;
  std::vector<MemorySample> samples_;
};

}  // namespace seam::app
