#include "measurement/kinds/imu/spectra/cosine_transform.h"

#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

using Complex = std::complex<double>;

// By Makhoul (1980): one transform of n complex numbers, the even places and then the odd ones
// backwards.
size_t place_of(size_t i, size_t n) {
  return i < (n + 1) / 2 ? 2 * i : 2 * (n - i) - 1;
}

Complex turned(size_t k, size_t n) {
  const double angle = maths::kPi * static_cast<double>(k) / (2 * static_cast<double>(n));
  return {std::cos(angle), -std::sin(angle)};
}

double weight(size_t k, size_t n) {
  return std::sqrt((k == 0 ? 1 : 2) / static_cast<double>(n));
}

}  // namespace

std::vector<double> cosine_transform(const std::vector<double>& series) {
  const size_t n = series.size();
  if (n < 2) return series;  // Eigen's FFT needs two.
  std::vector<Complex> in(n), out;
  for (size_t i = 0; i < n; ++i) in[i] = series[place_of(i, n)];
  Eigen::FFT<double>().fwd(out, in);
  std::vector<double> coefficients(n);
  for (size_t k = 0; k < n; ++k) coefficients[k] = weight(k, n) * (out[k] * turned(k, n)).real();
  return coefficients;
}

std::vector<double> inverse_cosine_transform(const std::vector<double>& coefficients) {
  const size_t n = coefficients.size();
  if (n < 2) return coefficients;
  std::vector<Complex> in(n), out;
  for (size_t k = 0; k < n; ++k) {
    const double real = coefficients[k] / weight(k, n);
    const double imaginary = k == 0 ? 0 : -coefficients[n - k] / weight(n - k, n);
    in[k] = Complex(real, imaginary) * std::conj(turned(k, n));
  }
  Eigen::FFT<double>().inv(out, in);
  std::vector<double> series(n);
  for (size_t i = 0; i < n; ++i) series[place_of(i, n)] = out[i].real();
  return series;
}

size_t quick_length(size_t n) {
  size_t best = 1;
  for (size_t two = 1; two <= n; two *= 2) {
    for (size_t three = two; three <= n; three *= 3) {
      for (size_t five = three; five <= n; five *= 5) best = std::max(best, five);
    }
  }
  return best;
}

}  // namespace seam::measurement
