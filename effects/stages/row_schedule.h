// When each row of a frame is exposed, and at which shared instants light is sampled for it.
#pragma once

#include "effects/stages/timing.h"
#include "sim_core/scene/frame.h"

namespace seam::effects {

struct RowScheduleOptions {
  // At least so many instants fall in each row's window (1 to kMaxInstantsPerRow).
  int instants_per_row = 8;
  // From which `clock_drift` counts.
  SimTime reference;
  // This frame's own latency (`frame_jitter`), added to the model's.
  SimDuration jitter;
};

// The head's cycle: its length, and when one begins.
struct HeadCycle {
  SimTime start;
  SimDuration length;
};

// The stamp of a frame as the camera takes it: in lock with the head's cycle where the timing has
// such a lock (`frame_sync`).
SimTime stamp_in_lock(const Timing& timing, SimTime stamp, const HeadCycle& cycle);

inline constexpr int kMaxInstantsPerRow = 4096;

// Row r integrates over [start, start + exposure], start = stamp + drift + latency + jitter +
// line_delay * r, each rounded to a nanosecond once (never a running sum). Instants stand on one
// even grid of spacing h = exposure / instants_per_row, so that rows share them.
//
// The weights of a row are those of the Euler-Maclaurin formula for a sum that starts at the
// fraction phi of a step inside the window,
//   sum over k >= 0 of f(phi + k) = integral from 0 of f - B1(phi) f(0) - B2(phi)/2 f'(0) - ...,
// whose two end terms are moved into the two outermost weights of each end. They are positive,
// add up to 1, have the window's middle as their mean time (so linear motion is exact), and the
// error for smooth light falls as h^3. Equal weights instead would let a row's mean time
// jump by half a step whenever another instant enters its window.
//
// Exposure 0, or one instant a row: each row samples the middle of its own window.
RowSchedule make_row_schedule(const Timing& timing, SimTime stamp, int height_px,
                              const RowScheduleOptions& options = {});

// The same for given windows, all equally long; rows may start at any times.
RowSchedule schedule_of_windows(std::vector<RowWindow> rows, int instants_per_row);

}  // namespace seam::effects
