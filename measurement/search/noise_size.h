// The size of a noise that the set leaves unknown. It is estimated from the measurements alone
// before any model is fitted, and may be wrong by more than chance. What a spread adds that any
// other size of this noise would add, too, is no effect.
#pragma once

#include "measurement/judge/judge.h"

namespace seam::measurement {

// Where the noises that were found say no more than another size of the estimated noise would:
// gives the problem that size, and returns true. All that was fitted before is then out of date.
bool correct_noise(Problem& problem, const Grown& best);

}  // namespace seam::measurement
