#pragma once

#include <cmath>

namespace seam::measurement {

// A logarithm is dear: one for many factors, as many as a double holds.
class LogOfProduct {
 public:
  void times(double factor) {
    product_ *= factor;
    if (product_ > 1e-200 && product_ < 1e200) return;
    sum_ += std::log(product_);
    product_ = 1;
  }
  double log() const { return sum_ + std::log(product_); }

 private:
  double product_ = 1, sum_ = 0;
};

// Variance of a number of a run's start that its first pose does not tell.
inline constexpr double kUntold2 = 1e4;

}  // namespace seam::measurement
