#include "measurement/noise/draw.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/maths.h"

namespace seam::measurement {

void add_wander(const effects::Wander& wander, const std::vector<double>& time_s,
                std::vector<size_t> rows, RandomStream stream, std::vector<double>& values) {
  std::stable_sort(rows.begin(), rows.end(),
                   [&](size_t a, size_t b) { return time_s[a] < time_s[b]; });
  double error = 0, before_s = 0;
  for (size_t k = 0; k < rows.size(); ++k) {
    const double dt_s = time_s[rows[k]] - before_s;
    before_s = time_s[rows[k]];
    // Rows at one time share the error.
    const double left = k == 0             ? 0
                        : dt_s == 0        ? 1
                        : wander.tau_s > 0 ? maths::exp(-dt_s / wander.tau_s)
                                           : 0;
    error = left * error + wander.sigma * std::sqrt(1 - left * left) * normal(stream, rows[k]);
    values[rows[k]] += error;
  }
}

}  // namespace seam::measurement
