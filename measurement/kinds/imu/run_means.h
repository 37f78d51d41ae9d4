// Means of runs that differ by more than their noise: a bias that is drawn anew at each power-on.
//
// No smooth function of time shows such a bias where runs are many, and where they are few any such
// function passes through all of them.
#pragma once

#include <vector>

namespace seam::measurement {

// What the readings of one run say of a mean: residual and variance, and when the run was.
struct RunMean {
  double value = 0, variance = 0;
  double middle_s = 0, lasts_s = 0;
};

// How much slow noise of a model moves means of runs against each other.
struct SlowNoise {
  double walk = 0, flicker = 0;  // As of an InertialSensor.
};

struct RunsApart {
  double p_value = 1;
  double rms = 0;  // Of the means about their own mean, less what noise makes of them.
};

// Whether means of runs agree. The variances come from the noise at low frequencies within the
// runs, of which each run shows `lines` independent lines.
RunsApart runs_apart(const std::vector<RunMean>& means, const SlowNoise& slow, double lines);

}  // namespace seam::measurement
