#include "measurement/sets/spline.h"

#include <algorithm>
#include <cmath>

namespace seam::measurement {
namespace {

// Slopes of the C2 cubic with not-a-knot ends (de Boor, A Practical Guide to Splines, ch. IV).
std::vector<double> knot_slopes(const std::vector<double>& t, const std::vector<double>& y) {
  const size_t n = t.size();
  std::vector<double> slope(n, 0);
  if (n == 2) slope[0] = slope[1] = (y[1] - y[0]) / (t[1] - t[0]);
  if (n < 3) return slope;
  if (n == 3) {
    const double d0 = (y[1] - y[0]) / (t[1] - t[0]), d1 = (y[2] - y[1]) / (t[2] - t[1]);
    const double second = (d1 - d0) / (t[2] - t[0]);
    for (size_t i = 0; i < 3; ++i) slope[i] = d0 + second * (2 * t[i] - t[0] - t[1]);
    return slope;
  }
  std::vector<double> lower(n), diagonal(n), upper(n), right(n);
  const auto h = [&](size_t i) { return t[i + 1] - t[i]; };
  const auto d = [&](size_t i) { return (y[i + 1] - y[i]) / h(i); };
  diagonal[0] = h(1);
  upper[0] = h(0) + h(1);
  right[0] = ((h(0) + 2 * upper[0]) * h(1) * d(0) + h(0) * h(0) * d(1)) / upper[0];
  for (size_t i = 1; i + 1 < n; ++i) {
    lower[i] = h(i);
    diagonal[i] = 2 * (h(i - 1) + h(i));
    upper[i] = h(i - 1);
    right[i] = 3 * (h(i) * d(i - 1) + h(i - 1) * d(i));
  }
  lower[n - 1] = h(n - 2) + h(n - 3);
  diagonal[n - 1] = h(n - 3);
  right[n - 1] =
      (h(n - 2) * h(n - 2) * d(n - 3) + (2 * lower[n - 1] + h(n - 2)) * h(n - 3) * d(n - 2)) /
      lower[n - 1];
  for (size_t i = 1; i < n; ++i) {
    const double factor = lower[i] / diagonal[i - 1];
    diagonal[i] -= factor * upper[i - 1];
    right[i] -= factor * right[i - 1];
  }
  slope[n - 1] = right[n - 1] / diagonal[n - 1];
  for (size_t i = n - 1; i-- > 0;) slope[i] = (right[i] - upper[i] * slope[i + 1]) / diagonal[i];
  return slope;
}

}  // namespace

Spline::Spline(std::vector<double> times, const std::vector<double>& values, double max_gap_s)
    : times_(std::move(times)), values_(values) {
  const size_t n = times_.size();
  straight_.assign(n, 0);
  slopes_.assign(n, 0);
  // Each run between gaps is a spline of its own.
  for (size_t first = 0; first < n;) {
    size_t last = first;
    while (last + 1 < n && times_[last + 1] - times_[last] <= max_gap_s) ++last;
    const std::vector<double> slopes =
        knot_slopes({times_.begin() + first, times_.begin() + last + 1},
                    {values_.begin() + first, values_.begin() + last + 1});
    std::copy(slopes.begin(), slopes.end(), slopes_.begin() + first);
    straight_[last] = 1;
    first = last + 1;
  }
  if (n < 2) return;
  step_ = (times_.back() - times_.front()) / static_cast<double>(n - 1);
  for (size_t i = 0; i < n; ++i) {
    if (std::abs(times_[i] - (times_.front() + step_ * static_cast<double>(i))) > 0.4 * step_)
      step_ = 0;
  }
}

size_t Spline::interval(double t) const {
  const size_t last = times_.size() - 2;
  if (step_ > 0) {
    size_t i = static_cast<size_t>(
        std::clamp((t - times_.front()) / step_, 0.0, static_cast<double>(last)));
    while (i > 0 && t < times_[i]) --i;
    while (i < last && t >= times_[i + 1]) ++i;
    return i;
  }
  const auto above = std::upper_bound(times_.begin(), times_.end(), t);
  const size_t i = above - times_.begin();
  return i == 0 ? 0 : std::min(i - 1, last);
}

double Spline::value(double t) const {
  if (times_.size() == 1 || t <= times_.front()) return values_.front();
  if (t >= times_.back()) return values_.back();
  const size_t i = interval(t);
  const double h = times_[i + 1] - times_[i];
  const double s = (t - times_[i]) / h;
  const double rise = values_[i + 1] - values_[i];
  if (straight_[i]) return values_[i] + s * rise;
  const double a = slopes_[i] * h - rise;
  const double b = rise - slopes_[i + 1] * h;
  return values_[i] + s * rise + s * (1 - s) * (a * (1 - s) + b * s);
}

double Spline::rate(double t) const {
  if (times_.size() == 1 || t < times_.front() || t > times_.back()) return 0;
  const size_t i = interval(t);
  const double h = times_[i + 1] - times_[i];
  const double s = (t - times_[i]) / h;
  const double rise = values_[i + 1] - values_[i];
  if (straight_[i]) return rise / h;
  const double a = slopes_[i] * h - rise;
  const double b = rise - slopes_[i + 1] * h;
  return (rise + (1 - 2 * s) * (a * (1 - s) + b * s) + s * (1 - s) * (b - a)) / h;
}

}  // namespace seam::measurement
