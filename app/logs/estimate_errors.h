// How far the clients' own estimates, which they log as values, are from what truly was: a robot's
// pose on the field, and the distance and bearing of the ball from its body.
//
// Names of values: `x_m`, `y_m`, `theta_rad` (in W, of one decision together), `ball_distance_m`
// and `ball_bearing_rad` (in the plane, in the body's frame). The truth is the log's record of
// poses, on each fourth step, straight between them, at the time of the decision; a frame was taken
// up to two decisions earlier, and what moved since then is part of the error.
#pragma once

#include <string>
#include <vector>

#include "scheduler/log/log.h"

namespace seam::app {

// One decision's error: estimate minus truth.
struct EstimateError {
  enum class Kind : uint8_t { position_m, heading_rad, ball_distance_m, ball_bearing_rad };
  Kind kind = Kind::position_m;
  SimTime time;
  int robot = 0;
  double error = 0;    // Of a position: the distance, never negative.
  double truth_m = 0;  // Of the ball's estimates: its true distance.
};
inline constexpr const char* kEstimateNames[] = {"position_m", "heading_rad", "ball_distance_m",
                                                 "ball_bearing_rad"};

// Of all decisions after `from`. Throws InputError where the log holds no poses.
std::vector<EstimateError> estimate_errors(const scheduler::Log& log, SimTime from = SimTime());

struct ErrorSummary {
  size_t count = 0;
  double mean = 0;  // Signed: the bias.
  double rms = 0;
  double median_abs = 0;
  double p90_abs = 0;
  double max_abs = 0;
};

ErrorSummary summarise(std::vector<double> errors);

}  // namespace seam::app
