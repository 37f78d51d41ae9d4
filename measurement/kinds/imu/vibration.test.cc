#include "effects/stages/inertial/vibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "measurement/kinds/imu/noise_lines.h"
#include "measurement/kinds/imu/spectra/spectral_peaks.h"
#include "sim_core/base/maths.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

// Of a line that is folded at half of the rate, that leans to either side, that is wide or narrow.
std::vector<effects::Vibration> lines() {
  return {{.rms = {0.3, 0, 0}, .frequency_hz = 7, .width_hz = 0.5, .skew = 0},
          {.rms = {0.1, 0, 0}, .frequency_hz = 20, .width_hz = 3, .skew = 1},
          {.rms = {2, 0, 0}, .frequency_hz = 60, .width_hz = 4, .skew = -0.7}};
}

double covariance(const effects::Vibration& line, double lag_s) {
  const double turn = 2 * maths::kPi * line.frequency_hz * lag_s;
  return line.rms[0] * line.rms[0] * std::exp(-maths::kPi * line.width_hz * lag_s) *
         (std::cos(turn) + line.skew * line.width_hz / (2 * line.frequency_hz) * std::sin(turn));
}

TEST(Vibration, HasThePowerOfItsAutocovariance) {
  constexpr double kDt_s = 0.01;
  for (const effects::Vibration& line : lines()) {
    for (const double omega : {0.05, 0.44, 1.3, 2.5, maths::kPi}) {
      double power = covariance(line, 0);
      for (int lag = 1; lag < 5000; ++lag)
        power += 2 * covariance(line, lag * kDt_s) * std::cos(omega * lag);
      EXPECT_NEAR(effects::vibration_power(line, 0, omega, kDt_s) / power, 1, 1e-9) << omega;
    }
  }
}

TEST(Vibration, HasTheAllanVarianceOfItsAutocovariance) {
  constexpr double kDt_s = 0.01;
  for (const effects::Vibration& line : lines()) {
    for (const int m : {1, 2, 7, 100}) {
      // Weights of a difference of means of m neighbours.
      double sum = 0;
      for (int i = 0; i < 2 * m; ++i)
        for (int j = 0; j < 2 * m; ++j)
          sum += ((i < m) == (j < m) ? 1 : -1) * covariance(line, std::abs(i - j) * kDt_s);
      EXPECT_NEAR(effects::vibration_allan_variance(line, 0, m, kDt_s) / (sum / (2.0 * m * m)), 1,
                  1e-9)
          << m;
    }
  }
}

// Against the expected power of lines of so many samples, by the definition of the transform.
TEST(Vibration, BandsOfFewSamplesHaveItsPower) {
  constexpr double kDt_s = 0.01;
  constexpr int kSamples = 240;
  const auto expected = [](const effects::Vibration& line, int k) {
    double sum = 0;
    for (int i = 0; i < kSamples; ++i)
      for (int j = 0; j < kSamples; ++j)
        sum += covariance(line, std::abs(i - j) * kDt_s) *
               std::cos(maths::kPi * k * (i + 0.5) / kSamples) *
               std::cos(maths::kPi * k * (j + 0.5) / kSamples);
    return 2 * sum / kSamples;
  };
  // The last one is far narrower than lines are apart: the samples show a sine.
  std::vector<effects::Vibration> all = lines();
  all.push_back({.rms = {1, 0, 0}, .frequency_hz = 14.1, .width_hz = 1e-5});
  for (const effects::Vibration& line : all) {
    const double folded_hz = std::min(line.frequency_hz, 100 - line.frequency_hz);
    const int middle = static_cast<int>(std::lround(2 * kSamples * folded_hz * kDt_s));
    for (const int half : {3, 12}) {
      double sum = 0;
      for (int k = middle - half; k <= middle + half; ++k) sum += expected(line, k);
      const double seen =
          (2 * half + 1) * effects::vibration_power_between(
                               line, 0, omega_of_line(middle - half - 0.5, kSamples),
                               omega_of_line(middle + half + 0.5, kSamples), kSamples, kDt_s);
      // The window of the samples is taken for an exponential one.
      EXPECT_NEAR(seen / sum, 1, 0.08) << line.frequency_hz << " " << half;
    }
  }
}

WhiteLines white_lines(size_t count, uint64_t seed) {
  const RandomStream stream = RandomStream{.seed = seed}.child("lines");
  WhiteLines lines{.step = maths::kPi / static_cast<double>(count)};
  for (size_t i = 0; i < count; ++i) {
    const double x = normal(stream, i);
    lines.power.push_back(x * x), lines.count.push_back(1);
  }
  return lines;
}

TEST(SpectralPeaks, AreFoundWhereALineIs) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    WhiteLines lines = white_lines(20000, seed);
    EXPECT_TRUE(peaks_of(lines, 0.02).empty()) << seed;
    const SpectralPeak truth{.omega = 5000.0 * lines.step, .width = 20.0 * lines.step};
    for (size_t i = 0; i < lines.power.size(); ++i)
      lines.power[i] *= 1 + 10 * height_at(truth, static_cast<double>(i) * lines.step);
    const std::vector<SpectralPeak> peaks = peaks_of(lines, 0.02);
    ASSERT_EQ(peaks.size(), 1u) << seed;
    EXPECT_NEAR(peaks[0].omega, truth.omega, truth.width / 2 + peaks[0].width / 2);
    EXPECT_GE(peaks[0].width, truth.width / 4);
    EXPECT_LE(peaks[0].width, truth.width * 4);
  }
}

TEST(SpectralPeaks, BandsAreNarrowNearThem) {
  const std::vector<SpectralPeak> peaks = {{.omega = 1, .width = 0.04}};
  EXPECT_DOUBLE_EQ(finest_at(peaks, 1), 0.01);
  EXPECT_DOUBLE_EQ(finest_at(peaks, 1.6), 0.1);
  EXPECT_EQ(finest_at({}, 1), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace seam::measurement
