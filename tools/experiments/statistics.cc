#include "tools/experiments/statistics.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace seam::tools {

double root_mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (double value : values) sum += value * value;
  return values.empty() ? 0 : std::sqrt(sum / static_cast<double>(values.size()));
}

double largest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

Interval interval_of(const std::vector<double>& values) {
  const double n = static_cast<double>(values.size());
  if (n < 2) return {mean_of(values), 0};
  const boost::math::students_t t(n - 1);
  return {mean_of(values), boost::math::quantile(t, 0.975) * deviation_of(values) / std::sqrt(n)};
}

Interval seed_interval(const std::vector<double>& by_run, size_t per_seed) {
  if (by_run.size() < 3 * per_seed) return interval_of(by_run);
  std::vector<double> means;
  for (size_t i = 0; i + per_seed <= by_run.size(); i += per_seed) {
    const auto first = by_run.begin() + static_cast<long>(i);
    means.push_back(mean_of({first, first + static_cast<long>(per_seed)}));
  }
  return interval_of(means);
}

std::vector<double> differences(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> all;
  for (size_t i = 0; i < a.size() && i < b.size(); ++i) all.push_back(a[i] - b[i]);
  return all;
}

}  // namespace seam::tools
