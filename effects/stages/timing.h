// Stage `timing`: when each row of a frame is exposed.
#pragma once

#include "effects/model.h"
#include "sim_core/base/random.h"

namespace seam::effects {

// What the timing effects of a model add up to. For a frame with stamp s (the start of row 0 by the
// camera's own clock) row v is exposed over [start, start + exposure] with
//   start = s + drift_ppm * 1e-6 * (s - reference) + latency + line_delay * v,
// and a point is seen at the window's middle.
struct Timing {
  double line_delay_s = 0;  // Negative: the last row first.
  double exposure_s = 0;
  double latency_s = 0;
  double drift_ppm = 0;
  double jitter_sigma_s = 0;   // A new latency for each frame.
  double per_exposure = 0;     // Latency of a frame, in units of its own exposure.
  int sync_period_frames = 0;  // 0: frames follow the camera's own clock.

  // Start of a row's window, seconds after the frame's stamp; `since_reference_s` is the stamp
  // minus the first time of the reference log. Small numbers only: stamps may be epoch seconds.
  double row_start_after_stamp_s(double row, double since_reference_s) const {
    return drift_ppm * 1e-6 * since_reference_s + latency_s + line_delay_s * row;
  }
  double row_middle_after_stamp_s(double row, double since_reference_s) const {
    return row_start_after_stamp_s(row, since_reference_s) + 0.5 * exposure_s;
  }

  // When a frame is taken that is stamped `since_start` after a cycle of the head began: at the
  // nearest of the instants in lock with the cycle. In one unit throughout; `cycle` 0: no cycle.
  double in_lock(double since_start, double cycle) const;

  // The latency that a frame has of its own, seconds, drawn from the camera's stream.
  double own_latency_s(RandomStream camera, uint64_t frame) const;
};

Timing timing_of(const Model& model);

}  // namespace seam::effects
