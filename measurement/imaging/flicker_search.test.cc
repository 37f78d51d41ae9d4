// Waves of lamps of known frequency, depth and phase, computed row by row from their sine.
#include "measurement/imaging/flicker_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/maths.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

RowLight lit(const std::vector<double>& times_s, int rows, double line_s, double frequency_hz,
             double depth, double phase_rad, double noise) {
  RowLight out;
  out.frame_time_s = times_s;
  out.weight.assign(times_s.size(), 1);
  for (int v = 0; v < rows; ++v) out.row_delay_s.push_back(v * line_s);
  const RandomStream stream{.seed = 3};
  uint64_t next = 0;
  for (const double t : times_s) {
    auto& values = out.relative.emplace_back();
    for (int v = 0; v < rows; ++v) {
      const double at = t + v * line_s;
      values.push_back(depth * std::sin(2 * maths::kPi * frequency_hz * at + phase_rad) +
                       noise * normal(stream, next++));
    }
  }
  return out;
}

// The phase belongs to t = 0, the frequency to the frames' middle: compared where the frames are.
void expect_wave(const std::vector<double>& found, double frequency_hz, double depth,
                 double phase_rad, const std::vector<double>& times_s) {
  const double span_s = times_s.back() - times_s.front();
  EXPECT_NEAR(found[0], frequency_hz, 0.2 / span_s);
  EXPECT_NEAR(found[1], depth, 0.1 * depth);
  const double middle_s = 0.5 * (times_s.front() + times_s.back());
  EXPECT_NEAR(
      std::remainder(2 * maths::kPi * (found[0] - frequency_hz) * middle_s + found[2] - phase_rad,
                     2 * maths::kPi),
      0, 0.15);
}

TEST(FlickerSearch, FindsTheWaveOfRollingRows) {
  // Not at the frames' own rhythm, which hides the wave's phase between frames.
  const std::vector<double> times_s = {10.0, 10.13, 10.31, 10.44, 10.78, 11.02, 11.17, 11.5};
  for (const double frequency_hz : {83.0, 100.0, 341.7}) {
    for (const double phase_rad : {-2.0, 0.4, 3.0}) {
      for (const double noise : {0.0, 0.02}) {
        SCOPED_TRACE(frequency_hz);
        const RowLight rows = lit(times_s, 240, 1e-4, frequency_hz, 0.1, phase_rad, noise);
        expect_wave(strongest_flicker(rows, 0), frequency_hz, 0.1, phase_rad, times_s);
      }
    }
  }
}

// All rows at once: the stamps alone tell, up to half their rate.
TEST(FlickerSearch, FindsASlowWaveFromStamps) {
  std::vector<double> times_s;
  for (int k = 0; k < 60; ++k) times_s.push_back(5 + 0.04 * k);
  for (const double frequency_hz : {2.3, 7.9}) {
    SCOPED_TRACE(frequency_hz);
    const RowLight rows = lit(times_s, 4, 0, frequency_hz, 0.05, 1, 0.002);
    expect_wave(strongest_flicker(rows, 0.04), frequency_hz, 0.05, 1, times_s);
  }
}

// The stronger of two.
TEST(FlickerSearch, TheStrongerWaveWins) {
  const std::vector<double> times_s = {0.0, 0.13, 0.31, 0.44, 0.78, 1.02};
  RowLight rows = lit(times_s, 240, 1e-4, 120, 0.1, 0, 0);
  const RowLight weak = lit(times_s, 240, 1e-4, 300, 0.05, 1, 0);
  for (size_t f = 0; f < times_s.size(); ++f) {
    for (size_t v = 0; v < 240; ++v) rows.relative[f][v] += weak.relative[f][v];
  }
  EXPECT_NEAR(strongest_flicker(rows, 0)[0], 120, 0.3);
}

// Rows of 20 ms hold 1,500 Hz x 20 ms = 30 waves, each of which eight frames tell eight ways; few
// rows reach less far; without rows in time the frames alone count.
TEST(FlickerSearch, CountsItsLooks) {
  std::vector<double> delays;
  for (int v = 0; v <= 200; ++v) delays.push_back(1e-4 * v);
  const FrameStamps stamps{.count = 8, .span_s = 1, .period_s = 0.1};
  EXPECT_NEAR(flicker_looks(delays, stamps, 8), 8 * 30, 1e-9);
  delays.assign({0, 0.005, 0.01, 0.015, 0.02});  // 0.45 * 5 / 20 ms = 112.5 Hz.
  EXPECT_NEAR(flicker_looks(delays, stamps, 8), 8 * 2.25, 1e-9);
  EXPECT_NEAR(flicker_looks({0, 0, 0}, stamps, 8), 8, 1e-9);
  EXPECT_EQ(flicker_looks({0, 0, 0}, stamps, 0), 1);
}

}  // namespace
}  // namespace seam::measurement
