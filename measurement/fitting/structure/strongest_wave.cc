#include "measurement/fitting/structure/strongest_wave.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "sim_core/base/maths.h"

namespace seam::measurement {

int strongest_wave(const std::vector<double>& times, const std::vector<double>& time_s,
                   const std::vector<double>& value, double step_hz, int count) {
  const double mean =
      std::accumulate(value.begin(), value.end(), 0.0) / static_cast<double>(value.size());
  // Runs often share their times: what was seen at one time goes through all waves as one.
  std::vector<double> at(times.size(), 0);
  for (size_t i = 0; i < value.size(); ++i) {
    const auto place = std::lower_bound(times.begin(), times.end(), time_s[i]);
    at[static_cast<size_t>(place - times.begin())] += value[i] - mean;
  }
  std::vector<double> c(static_cast<size_t>(count), 0), s = c;
  // Some side by side: each turns by its angle from one frequency to the next.
  constexpr size_t kTogether = 8;
  std::array<double, kTogether> re{}, im{}, c1{}, s1{};
  for (size_t first = 0; first < times.size(); first += kTogether) {
    for (size_t j = 0; j < kTogether; ++j) {
      const bool there = first + j < times.size();
      const size_t i = there ? first + j : first;
      const double angle = 2 * maths::kPi * step_hz * (times[i] - times.front());
      c1[j] = std::cos(angle), s1[j] = std::sin(angle);
      re[j] = there ? at[i] : 0, im[j] = 0;
    }
    for (size_t k = 0; k < c.size(); ++k) {
      double sum_c = c[k], sum_s = s[k];
      for (size_t j = 0; j < kTogether; ++j) {
        const double next = re[j] * c1[j] - im[j] * s1[j];
        im[j] = im[j] * c1[j] + re[j] * s1[j];
        re[j] = next;
        sum_c += re[j], sum_s += im[j];
      }
      c[k] = sum_c, s[k] = sum_s;
    }
  }
  size_t best = 0;
  const auto power = [&](size_t k) { return c[k] * c[k] + s[k] * s[k]; };
  for (size_t k = 1; k < c.size(); ++k) {
    if (power(k) > power(best)) best = k;
  }
  return static_cast<int>(best);
}

}  // namespace seam::measurement
