#include "sim_core/base/random.h"

#include <Random123/philox.h>
#include <xxhash.h>

#include <cmath>

#include "sim_core/base/maths.h"

namespace seam {
namespace {

double to_open_unit(uint32_t high, uint32_t low) {
  const uint64_t bits = (static_cast<uint64_t>(high) << 20) ^ (low >> 12);
  return (static_cast<double>(bits & ((uint64_t{1} << 52) - 1)) + 0.5) * 0x1p-52;
}

// log(k!) for k >= 0: Stirling's series where it is exact to double precision, the sum below.
double log_factorial(double k) {
  if (k < 16) {
    double sum = 0;
    for (int i = 2; i <= static_cast<int>(k); ++i) sum += maths::log(i);
    return sum;
  }
  const double x = k + 1;
  const double x2 = x * x;
  return (x - 0.5) * maths::log(x) - x + 0.91893853320467274178 +
         (1.0 / 12 - (1.0 / 360 - (1.0 / 1260 - 1.0 / (1680 * x2)) / x2) / x2) / x;
}

uint64_t poisson_by_inversion(double u, double mean) {
  double probability = maths::exp(-mean);
  double cumulative = probability;
  uint64_t k = 0;
  while (u > cumulative && k < 400) {
    ++k;
    probability *= mean / static_cast<double>(k);
    cumulative += probability;
  }
  return k;
}

}  // namespace

RandomStream RandomStream::child(std::string_view name) const {
  return {seed, XXH3_64bits_withSeed(name.data(), name.size(), stream)};
}

RandomStream RandomStream::child(uint64_t number) const {
  return {seed, XXH3_64bits_withSeed(&number, sizeof number, stream ^ 0x9e3779b97f4a7c15u)};
}

std::array<uint32_t, 4> random_bits(RandomStream stream, uint64_t index) {
  const philox4x32_ctr_t counter = {
      {static_cast<uint32_t>(index), static_cast<uint32_t>(index >> 32),
       static_cast<uint32_t>(stream.stream), static_cast<uint32_t>(stream.stream >> 32)}};
  const philox4x32_key_t key = {
      {static_cast<uint32_t>(stream.seed), static_cast<uint32_t>(stream.seed >> 32)}};
  const philox4x32_ctr_t bits = philox4x32(counter, key);
  return {bits[0], bits[1], bits[2], bits[3]};
}

double uniform(RandomStream stream, uint64_t index) {
  const auto bits = random_bits(stream, index);
  return to_open_unit(bits[0], bits[1]);
}

double normal(RandomStream stream, uint64_t index) {
  const auto bits = random_bits(stream, index);
  const double radius = std::sqrt(-2.0 * maths::log(to_open_unit(bits[0], bits[1])));
  return radius * maths::cos(2.0 * maths::kPi * to_open_unit(bits[2], bits[3]));
}

uint64_t poisson(RandomStream stream, uint64_t index, double mean) {
  if (!(mean > 0)) return 0;
  if (mean < 30) return poisson_by_inversion(uniform(stream, index), mean);
  // W. Hormann, "The transformed rejection method for generating Poisson random variables", 1993.
  const double b = 0.931 + 2.53 * std::sqrt(mean);
  const double a = -0.059 + 0.02483 * b;
  const double inverse_alpha = 1.1239 + 1.1328 / (b - 3.4);
  const double v_r = 0.9277 - 3.6224 / (b - 2);
  const double log_mean = maths::log(mean);
  const RandomStream attempts = stream.child("poisson").child(index);
  for (uint64_t attempt = 0;; ++attempt) {
    const auto bits = random_bits(attempts, attempt);
    const double u = to_open_unit(bits[0], bits[1]) - 0.5;
    const double v = to_open_unit(bits[2], bits[3]);
    const double us = 0.5 - std::abs(u);
    const double k = std::floor((2 * a / us + b) * u + mean + 0.43);
    if (us >= 0.07 && v <= v_r) return static_cast<uint64_t>(k);
    if (k < 0 || (us < 0.013 && v > us)) continue;
    if (maths::log(v) + maths::log(inverse_alpha) - maths::log(a / (us * us) + b) <=
        k * log_mean - mean - log_factorial(k)) {
      return static_cast<uint64_t>(k);
    }
  }
}

}  // namespace seam
