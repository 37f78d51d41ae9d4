// The clocks of periodic things: cameras, joint frames, behaviours. Tick i is at
// offset + i * period * (1 + drift), never a running sum, plus a seeded jitter of its own.
#pragma once

#include <cstdint>

#include "sim_core/random.h"
#include "sim_core/time.h"

namespace seam::scheduler {

struct ClockSettings {
  SimDuration offset;       // Of tick 0 after the start of the run.
  SimDuration period;       // Positive.
  double drift = 0;         // 1e-6 is one part in a million slow: each period is longer by this part.
  double jitter_sigma_s = 0;  // Spread of each tick alone; cut at 0.45 of the period.
};

class Clock {
 public:
  Clock() = default;
  // `jitter` draws this clock's jitter and nothing else's. A clock locked to another is a clock
  // with the other's settings and jitter stream, and a phase added to the offset.
  Clock(const ClockSettings& settings, RandomStream jitter);

  SimTime tick(int64_t index) const;
  // The first tick at or after this time; never before tick 0.
  int64_t first_at_or_after(SimTime time) const;
  const ClockSettings& settings() const { return settings_; }

 private:
  ClockSettings settings_;
  RandomStream jitter_;
};

}  // namespace seam::scheduler
