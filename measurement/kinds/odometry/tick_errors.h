// What counting leaves out: a count of ticks is a whole number, a wheel's way is not. The count
// since the start of a run is off by up to half a tick whatever the way: an error that is bounded,
// new with each tick and the same while the wheel rests, not one that gathers.
#pragma once

#include <array>
#include <vector>

#include "effects/stages/locomotion.h"
#include "effects/stages/timing.h"
#include "measurement/kinds/odometry/walk_run.h"

namespace seam::measurement {

// Of one wheel's count at the time of a row's pose, in ticks.
struct CountError {
  double variance = 0;
  double kept = 0;   // This share of the error at the row before stands in it.
  double fresh = 0;  // Variance of the rest.
};

using CountErrors = std::vector<std::array<CountError, 2>>;  // By row: left, right.

// Whether ticks are whole numbers; a simulator's that are not count nothing.
bool counts(const WalkRun& run);

CountErrors count_errors(const WalkRun& run, const effects::Timing& timing = {});

// How the error of a wheel's count at a row goes with that at the row before.
std::vector<std::array<double, 2>> count_correlations(const WalkRun& run);

// What the wheels may have turned in each row that counted so: sum and difference as even as counts
// that are off by half a tick allow. Rates between single rows are told by these, not by
// counts, which say that a wheel goes on and stops again.
std::vector<std::array<double, 2>> steady_ticks(const WalkRun& run);

// Whether counting is coarse enough beside the noise of poses to be told of.
bool counting_matters(const effects::Wheels& wheels, const std::array<double, 3>& noise);

}  // namespace seam::measurement
