// Smooth interpolation of logs: the cubic spline with not-a-knot ends for any number of signals on
// common times (fourth order: with samples each 8 ms its error on a swinging head is below 1e-7
// rad, that of straight lines is visible in pixels).
#pragma once

#include <cstddef>
#include <vector>

namespace seam::measurement {

class Spline {
 public:
  Spline() = default;
  // Times must increase strictly. Across gaps of more than `max_gap_s` a straight line is drawn.
  Spline(std::vector<double> times, const std::vector<double>& values, double max_gap_s = 1e300);

  // Beyond the ends: the end's value.
  double value(double t) const;
  double rate(double t) const;

  const std::vector<double>& times() const { return times_; }

 private:
  size_t interval(double t) const;

  std::vector<double> times_;
  std::vector<double> values_;
  std::vector<double> slopes_;  // At the knots: Hermite form.
  std::vector<char> straight_;  // By interval.
  double step_ = 0;             // Of even logs, else 0.
};

}  // namespace seam::measurement
