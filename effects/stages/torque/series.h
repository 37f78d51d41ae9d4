// A series in powers of time, and where it first becomes negative.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace seam::effects {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr int kMostOrder = 15;  // Highest power of time in a piece's angle.

using Series = std::array<double, kMostOrder + 1>;  // Coefficients by power of time.

inline double value_of(const Series& f, double t, int order) {
  double sum = f[order];
  for (int k = order - 1; k >= 0; --k) sum = sum * t + f[k];
  return sum;
}

inline double slope_of(const Series& f, double t, int order) {
  double sum = order * f[order];
  for (int k = order - 1; k >= 1; --k) sum = sum * t + k * f[k];
  return sum;
}

// Where between `low` and `high` f, not negative at `low`, becomes negative: Newton's steps inside
// a bracket that halves where they leave it.
inline double root_between(const Series& f, double low, double high, int order) {
  double t = 0.5 * (low + high);
  for (int step = 0; step < 60; ++step) {
    const double value = value_of(f, t, order);
    (value >= 0 ? low : high) = t;
    const double wished = t - value / slope_of(f, t, order);
    const double next = wished > low && wished < high ? wished : 0.5 * (low + high);
    if (std::abs(next - t) <= 1e-15 * high || !(high > low)) return next;
    t = next;
  }
  return t;
}

// Where between `low` and `high` f, which falls at `low`, rises.
inline double lowest_between(const Series& f, double low, double high, int order) {
  for (int halving = 0; halving < 40; ++halving) {
    const double middle = 0.5 * (low + high);
    (slope_of(f, middle, order) < 0 ? low : high) = middle;
  }
  return high;
}

// The first time up to `h` at which f, not negative at 0, becomes negative; infinite: it does not.
// Between its samples f is looked at where it turns.
inline double first_fall(const Series& f, double h, int order) {
  double reach = 0;
  for (int k = order; k >= 1; --k) reach = (reach + std::abs(f[k])) * h;
  if (f[0] > reach) return kInfinity;
  constexpr int kSamples = 4;
  const auto positive = [&](double t) { return value_of(f, t, order) >= 0; };
  // A clamp that was just left, or a start from rest, stands at 0 but for rounding.
  if (f[0] <= 1e-12 * reach && slope_of(f, 0, order) < 0) return 0;
  double from = 0;
  for (int i = 1; i <= kSamples; ++i) {
    const double to = i == kSamples ? h : h * i / kSamples;
    if (!positive(to)) return root_between(f, from, to, order);
    if (slope_of(f, from, order) < 0 && slope_of(f, to, order) > 0) {
      const double lowest = lowest_between(f, from, to, order);
      if (!positive(lowest)) return root_between(f, from, lowest, order);
    }
    from = to;
  }
  return kInfinity;
}

}  // namespace seam::effects
