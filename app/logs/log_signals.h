// What a log holds as numbers over time, by the names that conditions read:
//
//   time_s                     simulated seconds
//   red1.NAME                  what red1's client logged as a value; holds until the next one
//   red1.command.pan_rad       what red1's client ordered, by the names of the viewer's series
//   truth.red1.x_m             truth, in the steps that the log keeps: x_m, y_m, heading_rad,
//                              ball_distance_m (on the field), and joints such as pan_rad
//   truth.ball.x_m             x_m, y_m, z_m
//   event.goal                 1 at the instant of such an event, else 0; red1.event.kick: red1's
//   own red1.event.printed         red1's behaviour printed a line, made a decision, was sent a
//   frame:
//                              printed, decision, frame
//
// Characters that cannot stand in such a name are written `_` in it: robot `red-1` is `red_1`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scheduler/log/log.h"

namespace seam::app {

// One number of a name, in the order of time.
struct SignalSample {
  SimTime time;
  uint32_t name = 0;  // Its place in the names asked for.
  double value = 0;
};

struct LogSignals {
  std::vector<SignalSample> samples;
  std::vector<bool> instant;  // By name: 0 but at its samples' own times.
  SimTime end;
};

// Of these names. Throws UsageError for a name that the log does not have, with the nearest one.
// Joints that the log does not keep are worked out by running its world again.
LogSignals read_signals(const scheduler::Log& log, const std::vector<std::string>& names);

// All names of a log, sorted.
std::vector<std::string> signal_names(const scheduler::Log& log);

}  // namespace seam::app
