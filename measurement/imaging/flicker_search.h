// The strongest periodic wave of residual light over frames whose rows are exposed one after the
// other.
#pragma once

#include <cstddef>
#include <vector>

#include "effects/model.h"

namespace seam::measurement {

// Residual light of rows relative to the predicted light, with weights.
struct RowLight {
  std::vector<double> frame_time_s;           // Middle of row 0's window.
  std::vector<double> row_delay_s;            // Of each row's window after row 0's.
  std::vector<std::vector<double>> relative;  // By frame, by row.
  std::vector<double> weight;                 // By frame: inverse variance of a relative value.
};

// When frames were taken. `period_s` 0: unknown, then from the span.
struct FrameStamps {
  size_t count = 0;
  double span_s = 0;
  double period_s = 0;
};

// RowLight::row_delay_s of an image of so many rows.
std::vector<double> row_delays(const effects::Model& model, int rows);
// Parameters of `lamp_flicker` to start from: frequency_hz, depth, phase_rad.
std::vector<double> strongest_flicker(const RowLight& rows, double period_s);
// How many frequencies it can tell apart.
double flicker_looks(const std::vector<double>& row_delay_s, const FrameStamps& stamps,
                     size_t lit_frames);

}  // namespace seam::measurement
