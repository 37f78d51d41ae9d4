#include "effects/stages/inertial/vibration.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

double square(double x) {
  return x * x;
}

// Kernels of q = exp(-decay) by half angles: exact for decays however small.
struct Kernel {
  double q, narrow;  // And 1 - q.
  explicit Kernel(double decay) : q(maths::exp(-decay)), narrow(-maths::expm1(-decay)) {}

  double below(double x) const { return square(narrow) + 4 * q * square(maths::sin(x / 2)); }
  double even(double x) const { return narrow * (1 + q) / below(x); }
  double odd(double x) const { return 2 * q * maths::sin(x) / below(x); }
  // The integral of the even one from 0 to x, which grows by 2 pi a turn.
  double even_up_to(double x) const {
    const double turns = std::round(x / (2 * maths::kPi)), half = x / 2 - turns * maths::kPi;
    return 2 * maths::kPi * turns +
           2 * maths::atan2((1 + q) * maths::sin(half), narrow * maths::cos(half));
  }
};

double leaning(const Vibration& line) {
  return line.skew * line.width_hz / (2 * line.frequency_hz);
}

double decay_of(const Vibration& line, double dt_s) {
  return maths::kPi * line.width_hz * dt_s;
}

double turn_of(const Vibration& line, double dt_s) {
  return 2 * maths::kPi * line.frequency_hz * dt_s;
}

// n samples see the autocovariance times 1 - lag / n. The exponential of the same area has this
// decay: 2 / n for a pure sine.
double decay_seen(double decay, double n) {
  const double x = decay * n;
  // Of (x - 1 + exp(-x)) / x^2, whose difference is lost where x is small.
  const double area = x < 1e-3 ? 0.5 - x / 6 : (x + maths::expm1(-x)) / square(x);
  return 1 / (n * area);
}

}  // namespace

double vibration_power(const Vibration& line, size_t axis, double omega, double dt_s) {
  const Kernel kernel(decay_of(line, dt_s));
  const double turn = turn_of(line, dt_s);
  const double even = kernel.even(omega - turn) + kernel.even(omega + turn);
  const double odd = kernel.odd(turn + omega) + kernel.odd(turn - omega);
  return square(line.rms[axis]) * 0.5 * std::max(0.0, even + leaning(line) * odd);
}

double vibration_power_between(const Vibration& line, size_t axis, double from, double to,
                               double samples, double dt_s) {
  const Kernel kernel(decay_seen(decay_of(line, dt_s), samples));
  const double turn = turn_of(line, dt_s);
  const double even = kernel.even_up_to(to - turn) - kernel.even_up_to(from - turn) +
                      kernel.even_up_to(to + turn) - kernel.even_up_to(from + turn);
  const double odd = maths::log(kernel.below(turn + to) * kernel.below(turn - from) /
                                (kernel.below(turn + from) * kernel.below(turn - to)));
  return square(line.rms[axis]) * 0.5 * std::max(0.0, even + leaning(line) * odd) / (to - from);
}

// From the variance G(m) of the sum of m samples: (4 G(m) - G(2 m)) / (2 m^2).
double vibration_allan_variance(const Vibration& line, size_t axis, double m, double dt_s) {
  const double decay = decay_of(line, dt_s), turn = turn_of(line, dt_s);
  const auto power_of = [&](double k) {
    return std::polar(maths::exp(-decay * k), std::fmod(turn * k, 2 * maths::kPi));
  };
  const std::complex<double> z = power_of(1), rest = 1.0 - z, lag_0(1, -leaning(line));
  // A line that samples fold to nothing but a constant, which no difference of means sees.
  constexpr double kStays = 1e-4;
  if (std::abs(rest) * m < kStays) return 0;
  const auto of_sum = [&](double n) {
    return n + 2 * (lag_0 * z * (n - 1 - n * z + power_of(n)) / (rest * rest)).real();
  };
  return square(line.rms[axis]) * std::max(0.0, 4 * of_sum(m) - of_sum(2 * m)) / (2 * m * m);
}

}  // namespace seam::effects
