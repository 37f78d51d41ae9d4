#include "effects/stages/inertial/noise_series.h"

#include <gtest/gtest.h>

#include <cmath>

#include "effects/stages/inertial/inertial.h"
#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

constexpr double kDt_s = 0.008;
constexpr size_t kSamples = 4096;

std::vector<double> series_of(const InertialSensor& sensor, uint64_t seed, double mean = 0) {
  const NoiseSeries noise(sensor, 0, kDt_s, RandomStream{.seed = seed});
  std::vector<double> state(noise.state_size(), 0), series;
  for (size_t i = 0; i < kSamples; ++i) series.push_back(noise.reading(mean, i, state));
  return series;
}

// The mean power of the transform's lines `from` to `to`, over many series, by its definition.
double power_of(const InertialSensor& sensor, size_t from, size_t to) {
  constexpr uint64_t kSeeds = 24;
  double sum = 0;
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    const std::vector<double> series = series_of(sensor, seed);
    for (size_t k = from; k < to; ++k) {
      double line = 0;
      for (size_t i = 0; i < kSamples; ++i)
        line += series[i] * std::cos(maths::kPi * static_cast<double>(k) *
                                     (static_cast<double>(i) + 0.5) / kSamples);
      sum += line * line * 2 / kSamples / static_cast<double>(to - from) / kSeeds;
    }
  }
  return sum;
}

void expect_power(const InertialSensor& sensor, const char* of) {
  for (const auto& [from, to] :
       {std::pair<size_t, size_t>(4, 16), {100, 112}, {1000, 1012}, {3900, 3912}}) {
    double expected = 0;
    for (size_t k = from; k < to; ++k)
      expected += noise_power(sensor, 0, maths::kPi * static_cast<double>(k) / kSamples, kDt_s) /
                  static_cast<double>(to - from);
    // Of 288 squares each; octaves make ripples of some per cent.
    EXPECT_NEAR(power_of(sensor, from, to) / expected, 1, 4 * std::sqrt(2.0 / 288) + 0.03)
        << of << " " << from;
  }
}

TEST(NoiseSeries, HasThePowerOfItsParts) {
  InertialSensor white, flicker, walk, line;
  white.white[0] = 0.3;
  flicker.flicker[0] = 0.2;
  walk.walk[0] = 0.1;
  line.vibrations = {{.rms = {0.4, 0, 0}, .frequency_hz = 15.3, .width_hz = 1.5, .skew = -0.6}};
  expect_power(white, "white");
  expect_power(flicker, "flicker");
  expect_power(walk, "walk");
  expect_power(line, "line");
}

// Whole steps of the sum, whose rest is never lost.
TEST(NoiseSeries, RoundsWhatIsAddedUp) {
  InertialSensor sensor;
  sensor.rounding[0] = 0.01 / std::sqrt(12.0);
  const std::vector<double> series = series_of(sensor, 1, 3.217);
  double sum = 0;
  for (size_t i = 0; i < kSamples; ++i) {
    const double steps = series[i] * kDt_s / 0.01;
    EXPECT_NEAR(steps, std::round(steps), 1e-9);
    sum += series[i] * kDt_s;
    EXPECT_LE(std::abs(sum - 3.217 * kDt_s * static_cast<double>(i + 1)), 0.005 + 1e-9);
  }
}

TEST(NoiseSeries, GoesOnFromItsState) {
  InertialSensor sensor;
  sensor.white[0] = sensor.flicker[0] = sensor.walk[0] = 0.1, sensor.rounding[0] = 1e-4;
  sensor.vibrations = {{.rms = {0.4, 0, 0}, .frequency_hz = 15, .width_hz = 1}};
  const NoiseSeries noise(sensor, 0, kDt_s, RandomStream{.seed = 3});
  std::vector<double> state(noise.state_size(), 0);
  for (uint64_t i = 0; i < 10; ++i) noise.reading(1, i, state);
  std::vector<double> other = state;
  const NoiseSeries again(sensor, 0, kDt_s, RandomStream{.seed = 3});
  for (uint64_t i = 10; i < 20; ++i)
    EXPECT_EQ(noise.reading(1, i, state), again.reading(1, i, other));
}

}  // namespace
}  // namespace seam::effects
