#include "measurement/noise/few_errors.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace seam::measurement {
namespace {

constexpr double kLogRootTwoPi = 0.91893853320467274178;

// log of the normal distribution below y over its density there, and its inverse.
struct Mills {
  double log_ratio = 0;
  double inverse = 0;
};

Mills mills(double y) {
  if (y > -8) {
    const double below = 0.5 * std::erfc(-y / std::numbers::sqrt2);
    const double log_density = -0.5 * y * y - kLogRootTwoPi;
    return {std::log(below) - log_density, std::exp(log_density) / below};
  }
  // The asymptotic series; its terms fall until the thirtieth.
  double term = 1, sum = 1;
  for (int k = 1; k <= 12; ++k) {
    term *= -(2 * k - 1) / (y * y);
    sum += term;
  }
  const double ratio = -sum / y;
  return {std::log(ratio), 1 / ratio};
}

// Below this share of sigma the further error is as good as none.
constexpr double kLeastRatio = 1e-3;

// Places at which modes and mean squares are worked out; between them they are interpolated.
constexpr double kLogStep = 0.1, kLowest = -7, kHighest = 9;

}  // namespace

LogDensity FewErrors::more(double x, double ratio) const {
  if (sort_ == Sort::normal || ratio < kLeastRatio) {
    const double variance = sort_ == Sort::normal ? 1 + ratio * ratio : 1;
    return {-0.5 * x * x / variance - kLogRootTwoPi - 0.5 * std::log(variance), -x / variance,
            -1 / variance};
  }
  // An exponential of mean b on a normal error: phi(x) R(x - 1/b) / b, R = Phi / phi.
  const double y = x - 1 / ratio;
  const Mills m = mills(y);
  return {m.log_ratio - 0.5 * x * x - kLogRootTwoPi - std::log(ratio), m.inverse - 1 / ratio,
          -m.inverse * (m.inverse + y)};
}

double FewErrors::share_of_more(double error, double sigma, double fraction) const {
  const double x = error / sigma;
  if (fraction >= 1) return 1;
  const double usual = std::log1p(-fraction) - 0.5 * x * x - kLogRootTwoPi;
  const double other = std::log(fraction) + more(x, size_ / sigma).value;
  return 1 / (1 + std::exp(usual - other));
}

LogDensity FewErrors::at(double error, double sigma, double fraction) const {
  const double x = error / sigma;
  const double usual = std::log1p(-fraction) - 0.5 * x * x - kLogRootTwoPi;
  const LogDensity far = more(x, size_ / sigma);
  const double other = std::log(fraction) + far.value;
  const double top = std::max(usual, other);
  const double a = std::exp(usual - top), b = std::exp(other - top), w = b / (a + b);
  const double slope = (1 - w) * -x + w * far.slope;
  const double second = (1 - w) * (x * x - 1) + w * (far.curvature + far.slope * far.slope);
  return {top + std::log(a + b) - std::log(sigma), slope / sigma,
          (second - slope * slope) / (sigma * sigma)};
}

double FewErrors::mode_of(double ratio, double fraction) const {
  if (sort_ == Sort::normal || ratio < kLeastRatio) return 0;
  const FewErrors unit(sort_, fraction, ratio);
  // A tail that is nearly all has its own mode, which lies below 3 for any size.
  double low = 0, high = 4;
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = 0.5 * (low + high);
    (unit.at(middle, 1, fraction).slope > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

namespace {

// The integral of a function over all errors, in units of sigma: trapezoids over the normal part,
// and over what lies beyond, in steps of its own width. A function whose errors lie on both sides
// is even.
template <typename Function>
double integral(const Function& f, bool both_sides, double width, double step) {
  constexpr double kReach = 9;
  double sum = 0;
  const int steps = static_cast<int>(std::lround(2 * kReach / step));
  const auto normal_part = [&](int k) {
    return (k == 0 || k == steps ? 0.5 : 1) * step * f(-kReach + k * step);
  };
  // Where both sides are alike, one is enough.
  for (int k = both_sides ? steps / 2 + 1 : 0; k <= steps; ++k) sum += normal_part(k);
  if (both_sides) sum = normal_part(steps / 2) + 2 * sum;
  const double far = both_sides ? kReach * width : kReach + 40 * width;
  const int beyond = 6 * steps / 5;
  const double longer = (far - kReach) / beyond;
  if (!(longer > 0)) return sum;
  for (int k = 0; k <= beyond; ++k) {
    const double weight = (k == 0 || k == beyond ? 0.5 : 1) * longer, x = kReach + k * longer;
    sum += (both_sides ? 2 : 1) * weight * f(x);
  }
  return sum;
}

constexpr double kFine = 0.125, kCoarse = 0.5;

}  // namespace

double FewErrors::width(double ratio) const {
  return sort_ == Sort::normal ? std::sqrt(1 + ratio * ratio) : ratio;
}

double FewErrors::mean_of(double ratio, double fraction, double step) const {
  if (sort_ == Sort::normal) return 0;
  const FewErrors unit(sort_, fraction, ratio);
  const double mode = mode_of(ratio, fraction), highest = unit.at(mode, 1, fraction).value;
  const auto part = [&](double x) {
    const double l = unit.at(x, 1, fraction).value;
    return std::exp(l) * std::copysign(std::sqrt(2 * std::max(0.0, highest - l)), x - mode);
  };
  return integral(part, false, width(ratio), step);
}

double FewErrors::mean_square_of(double ratio, double fraction, double step) const {
  const FewErrors unit(sort_, fraction, ratio);
  const double highest = unit.at(mode_of(ratio, fraction), 1, fraction).value;
  const auto part = [&](double x) {
    const double l = unit.at(x, 1, fraction).value;
    return std::exp(l) * 2 * std::max(0.0, highest - l);
  };
  return integral(part, sort_ == Sort::normal, width(ratio), step);
}

double FewErrors::mean_square_of_second_of(double ratio) const {
  const FewErrors unit(sort_, fraction_, ratio);
  const auto part = [&](double x) {
    const double lot = unit.share_of_more(x, 1, fraction_);
    return std::exp(unit.at(x, 1, fraction_).value) * mean_square_of(ratio, lot, kCoarse);
  };
  return integral(part, sort_ == Sort::normal, width(ratio), kCoarse);
}

FewErrors::Place FewErrors::place(double sigma, bool second) const {
  const double at =
      (std::clamp(std::log(size_ / sigma), kLowest, kHighest - kLogStep) - kLowest) / kLogStep;
  const auto node = static_cast<size_t>(at);
  constexpr auto kNodes = static_cast<size_t>((kHighest - kLowest) / kLogStep) + 2;
  if (table_.empty()) table_.resize(kNodes);
  for (const size_t n : {node, node + 1}) {
    Place& there = table_[n];
    const double ratio = std::exp(kLowest + kLogStep * static_cast<double>(n));
    if (!(there.mean_square > 0)) {
      there.mode = mode_of(ratio, fraction_);
      there.mean = mean_of(ratio, fraction_, kFine);
      there.mean_square = mean_square_of(ratio, fraction_, kFine);
    }
    if (second && !(there.mean_square_of_second > 0))
      there.mean_square_of_second = mean_square_of_second_of(ratio);
  }
  const double share = at - static_cast<double>(node);
  const auto between = [&](double Place::*value) {
    return table_[node].*value + share * (table_[node + 1].*value - table_[node].*value);
  };
  return {between(&Place::mode), between(&Place::mean), between(&Place::mean_square),
          between(&Place::mean_square_of_second)};
}

double FewErrors::mode(double sigma) const {
  return sort_ == Sort::normal ? 0 : sigma * place(sigma, false).mode;
}

double FewErrors::mean(double sigma) const {
  return sort_ == Sort::normal ? 0 : place(sigma, false).mean;
}

double FewErrors::mean_square(double sigma) const {
  return place(sigma, false).mean_square;
}

double FewErrors::mean_square_of_second(double sigma) const {
  return place(sigma, true).mean_square_of_second;
}

double FewErrors::variance(double sigma) const {
  const double more = sort_ == Sort::normal ? fraction_ : fraction_ * (2 - fraction_);
  return sigma * sigma + more * size_ * size_;
}

Deviance FewErrors::deviance(double error, double sigma, double fraction) const {
  const double mode = this->mode(sigma);
  const double highest = at(mode, sigma, fraction).value, here = at(error, sigma, fraction).value;
  return {std::copysign(std::sqrt(2 * std::max(0.0, highest - here)), error - mode),
          -2 * (highest + kLogRootTwoPi)};
}

}  // namespace seam::measurement
