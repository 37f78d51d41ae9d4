#include "measurement/fitting/structure/strongest_wave.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

double power_of(const std::vector<double>& time_s, const std::vector<double>& value, double hz) {
  double mean = 0, c = 0, s = 0;
  for (const double v : value) mean += v / static_cast<double>(value.size());
  for (size_t i = 0; i < value.size(); ++i) {
    const double angle = 2 * maths::kPi * hz * (time_s[i] - time_s[0]);
    c += (value[i] - mean) * std::cos(angle), s += (value[i] - mean) * std::sin(angle);
  }
  return c * c + s * s;
}

// Wave by wave, each sum for itself; times of several runs are shared or all their own.
TEST(StrongestWave, IsThatOfEachWaveAlone) {
  constexpr double kStep_hz = 0.05;
  constexpr int kCount = 60;
  for (const bool shared : {true, false}) {
    for (const int hidden : {3, 17, 44}) {
      std::vector<double> time_s, value;
      for (int run = 0; run < 3; ++run) {
        for (int i = 0; i < 101; ++i) {
          time_s.push_back(0.1 * i + (shared ? 0 : 0.003 * run));
          value.push_back(2 + std::sin(2 * maths::kPi * kStep_hz * (hidden + 1) * time_s.back()) +
                          0.5 * std::cos(29.0 * i + run));
        }
      }
      int best = 0;
      for (int k = 1; k < kCount; ++k) {
        if (power_of(time_s, value, kStep_hz * (k + 1)) >
            power_of(time_s, value, kStep_hz * (best + 1)))
          best = k;
      }
      const std::set<double> once(time_s.begin(), time_s.end());
      EXPECT_EQ(strongest_wave({once.begin(), once.end()}, time_s, value, kStep_hz, kCount), best);
      EXPECT_EQ(best, hidden);
    }
  }
}

}  // namespace
}  // namespace seam::measurement
