#include "measurement/kinds/imu/spectra/allan.h"

#include <cmath>
#include <limits>

#include "measurement/numerics/moments.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {

std::vector<CurvePoint> allan_deviation(const std::vector<double>& series, double dt_s) {
  const size_t n = series.size();
  const double mean = mean_of(series);
  std::vector<double> sum(n + 1, 0);  // From which a difference of means is three look-ups.
  for (size_t i = 0; i < n; ++i) sum[i + 1] = sum[i] + series[i] - mean;
  std::vector<CurvePoint> points;
  size_t before = 0;
  for (double size = 1; size <= static_cast<double>(n) / 4; size *= std::sqrt(2.0)) {
    const auto m = static_cast<size_t>(std::llround(size));
    if (m == before) continue;
    before = m;
    double squares = 0;
    const size_t count = n + 1 - 2 * m;
    for (size_t i = 0; i < count; ++i) {
      const double difference = sum[i + 2 * m] - 2 * sum[i + m] + sum[i];
      squares += difference * difference;
    }
    const auto wide = static_cast<double>(m), all = static_cast<double>(n);
    const double deviation = std::sqrt(squares / (2 * static_cast<double>(count))) / wide;
    const double freedom = (3 * (all - 1) / (2 * wide) - 2 * (all - 2) / all) * 4 * wide * wide /
                           (4 * wide * wide + 5);
    points.push_back({.at = wide * dt_s,
                      .value = deviation,
                      .sigma = deviation / std::sqrt(2 * std::max(1.0, freedom)),
                      .expected = std::numeric_limits<double>::quiet_NaN()});
  }
  return points;
}

// The integral of power * 2 sin^4(m omega / 2) / (m sin(omega / 2))^2 / pi over 0 to pi, on a
// logarithmic grid; where the sine runs through many waves between two places, its fourth power is
// its mean, 3/8.
double allan_deviation_of(const std::function<double(double omega)>& power, double m) {
  constexpr int kSteps = 4000;
  constexpr double kRange = 1e4;  // Below 1 / m so far nothing is left: sin^4 falls as omega^4.
  const double low = std::log(1 / (kRange * m)), step = (std::log(maths::kPi) - low) / kSteps;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double omega = std::exp(low + (i + 0.5) * step);
    const double sine = std::sin(m * omega / 2);
    const bool resolved = m * omega * step < 0.5;
    const double fourth = resolved ? sine * sine * sine * sine : 0.375;
    const double wide = m * std::sin(omega / 2);
    sum += power(omega) * 2 * fourth / (wide * wide) * omega * step;
  }
  return std::sqrt(sum / maths::kPi);
}

}  // namespace seam::measurement
