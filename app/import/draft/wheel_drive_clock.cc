// Two clocks, of wheels and of poses: the shift under which both show one motion.
#include <algorithm>
#include <cmath>

#include "app/import/draft/wheel_drive.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/maths.h"

namespace seam::app {
namespace {

constexpr size_t kMostSamples = 4000;

// Rates over even steps of time: forward and turning, each in any unit.
struct Rates {
  double start_s = 0;
  std::vector<std::array<double, 2>> at;
};

// What accumulates (a way and an angle) at times, as rates over steps of `step_s`.
Rates rates_of(const std::vector<double>& time_s, const std::vector<std::array<double, 2>>& sums,
               double step_s) {
  Rates rates{.start_s = time_s.front()};
  size_t next = 0;
  const auto value = [&](double t) {
    while (next + 2 < time_s.size() && time_s[next + 1] < t) ++next;
    const double share = (t - time_s[next]) / (time_s[next + 1] - time_s[next]);
    return std::array<double, 2>{sums[next][0] + share * (sums[next + 1][0] - sums[next][0]),
                                 sums[next][1] + share * (sums[next + 1][1] - sums[next][1])};
  };
  std::array<double, 2> before = value(time_s.front());
  for (double t = time_s.front() + step_s; t <= time_s.back(); t += step_s) {
    const std::array<double, 2> now = value(t);
    rates.at.push_back({now[0] - before[0], now[1] - before[1]});
    before = now;
  }
  return rates;
}

struct Series {
  std::vector<double> time_s;
  std::vector<std::array<double, 2>> sums;

  void add(double t, double way, double angle) {
    if (!time_s.empty() && !(t > time_s.back())) return;
    time_s.push_back(t), sums.push_back({way, angle});
  }
};

double seconds_since(int64_t origin, int64_t ns) {
  return 1e-9 * static_cast<double>(ns - origin);
}

Series of_wheels(const Drive& drive) {
  Series series;
  double way = 0, angle = 0;
  for (size_t k = 0; k < drive.rows.size(); ++k) {
    way += drive.since[k][0] + drive.since[k][1], angle += drive.since[k][1] - drive.since[k][0];
    series.add(seconds_since(drive.rows.front().ns, drive.rows[k].ns), way, angle);
  }
  return series;
}

Series of_poses(const Drive& drive) {
  Series series;
  double way = 0, angle = 0;
  const std::vector<PlanarPose>& poses = drive.poses;
  for (size_t k = 0; k < poses.size(); ++k) {
    if (k > 0) {
      const double turn = maths::wrap_angle(poses[k].theta_rad - poses[k - 1].theta_rad);
      const double heading = poses[k - 1].theta_rad + 0.5 * turn;
      way += std::cos(heading) * (poses[k].x_m - poses[k - 1].x_m) +
             std::sin(heading) * (poses[k].y_m - poses[k - 1].y_m);
      angle += turn;
    }
    series.add(seconds_since(poses.front().ns, poses[k].ns), way, angle);
  }
  return series;
}

// Correlation of one channel where the second series begins `lag` steps after the first; 0 where
// either does not vary.
double correlation(const Rates& a, const Rates& b, std::ptrdiff_t lag, size_t channel) {
  const auto size = [](const Rates& r) { return static_cast<std::ptrdiff_t>(r.at.size()); };
  const std::ptrdiff_t from = std::max<std::ptrdiff_t>(0, lag),
                       to = std::min(size(a), lag + size(b));
  double n = 0, sa = 0, sb = 0, aa = 0, bb = 0, ab = 0;
  for (std::ptrdiff_t i = from; i < to; ++i) {
    const double x = a.at[static_cast<size_t>(i)][channel],
                 y = b.at[static_cast<size_t>(i - lag)][channel];
    ++n, sa += x, sb += y, aa += x * x, bb += y * y, ab += x * y;
  }
  const double va = aa - sa * sa / n, vb = bb - sb * sb / n;
  return va > 1e-12 * aa && vb > 1e-12 * bb ? std::abs(ab - sa * sb / n) / std::sqrt(va * vb) : 0;
}

// The correlation at each lag from `from` to `to`: of both channels together, since one alone may
// repeat itself; of the one that varies where the other does not.
std::vector<double> correlations(const Rates& a, const Rates& b, std::ptrdiff_t from,
                                 std::ptrdiff_t to) {
  std::vector<double> at;
  for (std::ptrdiff_t lag = from; lag <= to; ++lag) {
    const double forward = correlation(a, b, lag, 0), turning = correlation(a, b, lag, 1);
    at.push_back(forward > 0 && turning > 0 ? 0.5 * (forward + turning)
                                            : std::max(forward, turning));
  }
  return at;
}

std::ptrdiff_t best_of(const std::vector<double>& at) {
  return std::max_element(at.begin(), at.end()) - at.begin();
}

// The best beyond the peak's own flanks, which end where it has fallen to half.
double best_elsewhere(const std::vector<double>& at) {
  const std::ptrdiff_t best = best_of(at), size = static_cast<std::ptrdiff_t>(at.size());
  const auto value = [&](std::ptrdiff_t i) { return at[static_cast<size_t>(i)]; };
  std::ptrdiff_t low = best, high = best;
  while (low > 0 && value(low) > 0.5 * value(best)) --low;
  while (high + 1 < size && value(high) > 0.5 * value(best)) ++high;
  double other = 0;
  for (std::ptrdiff_t i = 0; i < size; ++i) {
    if (i < low || i > high) other = std::max(other, value(i));
  }
  return other;
}

}  // namespace

ClockShift best_clock_shift(const Drive& drive) {
  const Series wheels = of_wheels(drive), poses = of_poses(drive);
  constexpr std::ptrdiff_t kFewest = 20, kFiner = 20;
  const auto count = [](const auto& list) { return static_cast<std::ptrdiff_t>(list.size()); };
  if (count(wheels.time_s) < kFewest || count(poses.time_s) < kFewest) return {};
  const double longest = std::max(wheels.time_s.back(), poses.time_s.back());
  std::vector<double> steps;
  for (size_t i = 1; i < wheels.time_s.size(); ++i)
    steps.push_back(wheels.time_s[i] - wheels.time_s[i - 1]);
  double step_s = std::max(measurement::median_of(steps), longest / kMostSamples);
  Rates a = rates_of(wheels.time_s, wheels.sums, step_s),
        b = rates_of(poses.time_s, poses.sums, step_s);
  if (count(a.at) < kFewest || count(b.at) < kFewest) return {};
  // Both must have run together for half of the shorter one.
  const std::ptrdiff_t least = std::min(count(a.at), count(b.at)) / 2;
  std::vector<double> at = correlations(a, b, least - count(b.at), count(a.at) - least);
  ClockShift shift{.other = best_elsewhere(at)};
  std::ptrdiff_t lag = best_of(at) + least - count(b.at);
  shift.correlation = at[static_cast<size_t>(best_of(at))];
  // Then nearby in smaller steps: their sums are straight between samples.
  step_s /= static_cast<double>(kFiner);
  a = rates_of(wheels.time_s, wheels.sums, step_s), b = rates_of(poses.time_s, poses.sums, step_s);
  at = correlations(a, b, kFiner * (lag - 1), kFiner * (lag + 1));
  lag = best_of(at) + kFiner * (lag - 1);
  shift.ns = drive.rows.front().ns - drive.poses.front().ns +
             std::llround(static_cast<double>(lag) * step_s * 1e9);
  return shift;
}

}  // namespace seam::app
