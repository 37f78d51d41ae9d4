// What counting leaves out: a count of ticks is a whole number, a wheel's way is not.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "effects/stages/timing.h"
#include "effects/stages/walk/locomotion.h"
#include "measurement/kinds/odometry/walk_run.h"

namespace seam::measurement {

// How far wheels may be from where their ways in the mean have them at the times of a run's poses,
// in ticks: left, right.
struct CountErrors {
  std::array<Eigen::Matrix2d, 2> first;              // Covariance of the errors of way and speed.
  std::vector<std::array<RolledWay::Step, 2>> step;  // By row, from the row before.

  bool empty() const { return step.empty(); }
};

// Whether ticks are whole numbers; a simulator's that are not count nothing.
bool counts(const WalkRun& run);

// Finds the ways of the wheels of all runs that count. Wheels of one body start and stop alike.
void find_ways(std::vector<WalkRun>& runs);

CountErrors count_errors(const WalkRun& run, const effects::Timing& timing = {});

// Whether counting is coarse enough beside the noise of poses to be told of.
bool counting_matters(const effects::Wheels& wheels, const std::array<double, 3>& noise);

}  // namespace seam::measurement
