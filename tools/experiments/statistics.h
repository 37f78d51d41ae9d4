// The few statistics that the experiments report.
#pragma once

#include <cstddef>
#include <vector>

#include "measurement/numerics/moments.h"

namespace seam::tools {

using measurement::deviation_of;
using measurement::mean_of;
double root_mean_square(const std::vector<double>& values);
double largest(const std::vector<double>& values);

// A mean and the half width of its 95 % interval (Student's t over independent values).
struct Interval {
  double mean = 0;
  double half_width = 0;  // 0 where there is but one value.
};
Interval interval_of(const std::vector<double>& values);

// Of runs seed by seed, `per_seed` of them each: the interval over seeds of their means, or over
// the runs themselves where there are fewer than 3 seeds.
Interval seed_interval(const std::vector<double>& by_run, size_t per_seed);
// a[i] - b[i] of runs that share pose, seed and phase.
std::vector<double> differences(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace seam::tools
