// Errors of estimates where the model misses the noise. What it leaves out is in all residuals of a
// group alike, so that these are no independent draws, and errors that count them as such are too
// small: groups then differ in what they say of a parameter by more than their noise. The estimate
// by clusters (Liang and Zeger 1986) takes the variance of what each group adds to the slopes, and
// asks nothing of the residuals inside a group. Fewer than four groups are cut into stretches, as
// long as they can be: what hangs together over more than these is not seen.
#pragma once

#include "measurement/fitting/assess.h"

namespace seam::measurement {

// Widens the fit's errors of parameters of the mean to those of the groups, where these are
// larger: by more than chance where the error is at most `adequate`. Nothing changes where groups
// are not independent, nor at most `adequate` where there are fewer than four. Returns the largest
// factor, 1 for none.
double widen_by_group_scatter(const Problem& problem, double adequate, Assessment& assessment);

}  // namespace seam::measurement
