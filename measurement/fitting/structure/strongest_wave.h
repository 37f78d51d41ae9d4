// Which wave in time a series holds most of: a look along many frequencies at once.
#pragma once

#include <vector>

namespace seam::measurement {

// The k below `count` for which values hold most of a wave of frequency (k + 1) step_hz, by the sum
// of its squares with sine and cosine, the mean of the values taken out. `times` are those of the
// values, each once and in order.
int strongest_wave(const std::vector<double>& times, const std::vector<double>& time_s,
                   const std::vector<double>& value, double step_hz, int count);

}  // namespace seam::measurement
