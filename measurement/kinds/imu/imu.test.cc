#include <gtest/gtest.h>

#include <cmath>

#include "effects/kind.h"
#include "effects/stages/inertial/inertial.h"
#include "measurement/kinds/imu/noise_lines.h"
#include "measurement/kinds/imu/spectra/allan.h"
#include "measurement/kinds/imu/spectra/cosine_transform.h"
#include "sim_core/base/maths.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

std::vector<double> drawn(size_t n, std::string_view name) {
  const RandomStream stream = RandomStream{.seed = 7}.child(name);
  std::vector<double> series;
  for (size_t i = 0; i < n; ++i) series.push_back(normal(stream, i));
  return series;
}

TEST(Imu, HasTheKindAndStageThatTheTablesList) {
  EXPECT_STREQ(effects::kind_facts(effects::kImu).name, "imu");
  EXPECT_EQ(effects::to_string(effects::kInertial), "inertial");
}

TEST(CosineTransform, IsItsDefinition) {
  for (const size_t n : {1, 2, 5, 9, 12}) {
    const std::vector<double> series = drawn(n, "series");
    const std::vector<double> lines = cosine_transform(series);
    for (size_t k = 0; k < n; ++k) {
      double sum = 0;
      for (size_t i = 0; i < n; ++i)
        sum += series[i] * std::cos(maths::kPi * static_cast<double>(k) *
                                    (static_cast<double>(i) + 0.5) / static_cast<double>(n));
      EXPECT_NEAR(lines[k], sum * std::sqrt((k == 0 ? 1 : 2) / static_cast<double>(n)), 1e-12);
    }
    const std::vector<double> back = inverse_cosine_transform(lines);
    for (size_t i = 0; i < n; ++i) EXPECT_NEAR(back[i], series[i], 1e-12);
  }
}

// The reason for this transform: lines of a walk are independent, with the power that
// stages/inertial/inertial.h states, from the first one on.
TEST(CosineTransform, LinesOfAWalkAreIndependent) {
  constexpr size_t kSamples = 16, kWalks = 20000;
  std::vector<double> products(kSamples * kSamples, 0);
  const std::vector<double> steps = drawn(kSamples * kWalks, "walks");
  for (size_t walk = 0; walk < kWalks; ++walk) {
    std::vector<double> series(kSamples);
    double at = 0;
    for (size_t i = 0; i < kSamples; ++i) series[i] = at += steps[walk * kSamples + i];
    const std::vector<double> lines = cosine_transform(series);
    for (size_t a = 1; a < kSamples; ++a)
      for (size_t b = 1; b < kSamples; ++b)
        products[a * kSamples + b] += lines[a] * lines[b] / kWalks;
  }
  effects::InertialSensor sensor;
  sensor.walk[0] = 1;
  const auto power = [&](size_t k) {
    return effects::noise_power(sensor, 0, maths::kPi * static_cast<double>(k) / kSamples, 1);
  };
  // Five standard errors of a mean of so many products.
  const double close = 5 * std::sqrt(2.0 / kWalks);
  for (size_t a = 1; a < kSamples; ++a) {
    for (size_t b = 1; b < kSamples; ++b)
      EXPECT_NEAR(products[a * kSamples + b] / std::sqrt(power(a) * power(b)), a == b ? 1 : 0,
                  close)
          << a << " " << b;
  }
}

TEST(CosineTransform, QuickLengthsHaveSmallFactors) {
  EXPECT_EQ(quick_length(1), 1u);
  EXPECT_EQ(quick_length(7), 6u);
  EXPECT_EQ(quick_length(720001), 720000u);
}

TEST(Allan, OfWhiteNoiseFallsAsTheRootOfTime) {
  constexpr double kDt_s = 0.5;
  for (const CurvePoint& point : allan_deviation(drawn(200000, "white"), kDt_s)) {
    const double m = point.at / kDt_s;
    EXPECT_NEAR(point.value, 1 / std::sqrt(m), 4 * point.sigma) << m;
  }
}

// By the definition, with one pair of neighbours after another.
TEST(Allan, IsTheOverlappingEstimator) {
  const std::vector<double> series = {1, 4, 2, 8, 5, 7, 1, 3, 3, 6, 2, 9};
  const auto points = allan_deviation(series, 1);
  ASSERT_EQ(points.size(), 3u);
  for (const CurvePoint& point : points) {
    const auto m = static_cast<size_t>(point.at);
    double squares = 0, count = 0;
    for (size_t i = 0; i + 2 * m <= series.size(); ++i) {
      double first = 0, second = 0;
      for (size_t k = 0; k < m; ++k) first += series[i + k], second += series[i + m + k];
      const double difference = (second - first) / static_cast<double>(m);
      squares += difference * difference, ++count;
    }
    EXPECT_NEAR(point.value, std::sqrt(squares / (2 * count)), 1e-12);
  }
}

// Closed forms of IEEE Std 952, where means are over many samples.
TEST(Allan, OfAModelHasTheClosedForms) {
  const double dt_s = 0.01, m = 1000, tau_s = m * dt_s;
  const auto deviation = [&](effects::Triad effects::InertialSensor::*part, double size) {
    effects::InertialSensor sensor;
    (sensor.*part)[0] = size;
    return allan_deviation_of(
        [&](double omega) { return effects::noise_power(sensor, 0, omega, dt_s); }, m);
  };
  using Sensor = effects::InertialSensor;
  EXPECT_NEAR(deviation(&Sensor::white, 0.3) / (0.3 / std::sqrt(tau_s)), 1, 2e-3);
  EXPECT_NEAR(deviation(&Sensor::flicker, 0.3) / (0.3 * std::sqrt(2 * std::log(2) / maths::kPi)), 1,
              2e-3);
  EXPECT_NEAR(deviation(&Sensor::walk, 0.3) / (0.3 * std::sqrt(tau_s / 3)), 1, 2e-3);
  EXPECT_NEAR(deviation(&Sensor::rounding, 0.3) / (0.3 * std::sqrt(3) / tau_s), 1, 2e-3);
}

// A bias that walks follows a temperature that rises by chance, by as much as its error says.
TEST(NoiseLines, AWalkFollowsTheTemperatureByChance) {
  constexpr size_t kSamples = 4000, kSeeds = 80;
  double square = 0;
  size_t far = 0;
  for (size_t seed = 0; seed < kSeeds; ++seed) {
    const std::vector<double> white = drawn(kSamples, "white" + std::to_string(seed));
    const std::vector<double> steps = drawn(kSamples, "steps" + std::to_string(seed));
    ImuStretch stretch{.dt_s = 0.02};
    double at = 0;
    for (size_t i = 0; i < kSamples; ++i) {
      stretch.rows.push_back(i);
      stretch.temperature_c.push_back(25 - 6 * std::exp(-static_cast<double>(i) / 1500));
      stretch.samples[0].push_back(white[i] + (at += 0.02 * steps[i]));
    }
    ImuData data;
    data.stretches.push_back(std::move(stretch));
    const StretchMean mean = noise_of_axis(data, 0, 1, 0.02).means[0][0];
    const double over = mean.per_k * mean.per_k / mean.per_k_variance;
    square += std::min(over, 9.0) / kSeeds;
    if (over > 9) ++far;
  }
  // Of normal errors one in 370 is beyond three; the spectrum's own error makes some more.
  EXPECT_LE(far, kSeeds / 20);
  EXPECT_NEAR(square, 1, 0.6);
}

// What the temperature takes of a line is missing in its power: here the whole first one, of lines
// of which the walk fills only some.
TEST(NoiseLines, WhatTheTemperatureTookIsNoQuiet) {
  constexpr size_t kSamples = 256, kStretches = 400;
  constexpr double kStep = 0.15;  // Equal to white noise at about the twelfth line.
  ImuData data;
  for (size_t s = 0; s < kStretches; ++s) {
    const std::vector<double> white = drawn(kSamples, "quiet white" + std::to_string(s));
    const std::vector<double> steps = drawn(kSamples, "quiet steps" + std::to_string(s));
    ImuStretch stretch{.dt_s = 1};
    double at = 0;
    for (size_t i = 0; i < kSamples; ++i) {
      stretch.rows.push_back(i);
      stretch.temperature_c.push_back(
          25 - 3 * std::cos(maths::kPi * (static_cast<double>(i) + 0.5) / kSamples));
      stretch.samples[0].push_back(white[i] + (at += kStep * steps[i]));
    }
    data.stretches.push_back(std::move(stretch));
  }
  const SmoothSpectrum smooth = noise_of_axis(data, 0, 1, 0.125).smooth;
  effects::InertialSensor sensor;
  sensor.white[0] = 1, sensor.walk[0] = kStep;
  for (const double line : {2.0, 4.0}) {
    const double omega = omega_of_line(line, kSamples);
    // Some ten lines of each stretch tell the walk: 4 standard errors of so many squares.
    EXPECT_NEAR(smooth.at(omega) / effects::noise_power(sensor, 0, omega, 1), 1,
                4 * std::sqrt(2.0 / (10 * kStretches)))
        << line;
  }
}

}  // namespace
}  // namespace seam::measurement
