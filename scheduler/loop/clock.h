// The clocks of periodic things: cameras and behaviours. Tick i is at
// offset + (i * period / divisor) * (1 + drift), never a running sum, plus a seeded jitter.
#pragma once

#include <cstdint>

#include "sim_core/base/random.h"
#include "sim_core/base/time.h"
#include "sim_core/scenario/scenario.h"

namespace seam::scheduler {

struct ClockSettings {
  SimDuration offset;   // Of tick 0 after the start of the run.
  SimDuration period;   // Positive.
  int64_t divisor = 1;  // Ticks in a period: a clock locked to a cycle that is no multiple of it.
  double drift = 0;     // 1e-6 is one part in a million slow: each period is longer by this part.
  double jitter_sigma_s = 0;  // Spread of each tick alone; cut at 0.45 of the period.
};

class Clock {
 public:
  Clock() = default;
  // `jitter` draws this clock's jitter and nothing else's.
  Clock(const ClockSettings& settings, RandomStream jitter);

  SimTime tick(int64_t index) const;
  // The first tick at or after this time; never before tick 0.
  int64_t first_at_or_after(SimTime time) const;
  const ClockSettings& settings() const { return settings_; }

 private:
  ClockSettings settings_;
  RandomStream jitter_;
};

ClockSettings clock_settings(const ClockSpec& spec);
// The camera's own clock, or the head's cycle where it is locked to that.
ClockSettings clock_settings(const CameraSpec& camera);

}  // namespace seam::scheduler
