#include "measurement/suggest/wave_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

// Observations at places drawn by lot, with weights of their own and noise of one unit.
TEST(WaveSearch, FindsAWaveAmongScatteredObservations) {
  const RandomStream lot = RandomStream{.seed = 3}.child("wave");
  std::vector<double> at, weight, rest;
  for (uint64_t i = 0; i < 800; ++i) {
    at.push_back(5 + 10 * uniform(lot, 2 * i));
    weight.push_back(1 + uniform(lot, 2 * i + 1));
    // Residuals fall by what is added to the prediction.
    rest.push_back(-weight.back() * 1.5 * std::sin(2.7 * at.back() + 0.6) +
                   normal(lot.child("noise"), i));
  }
  const auto wave = strongest_wave(at, weight, rest);
  ASSERT_TRUE(wave);
  EXPECT_NEAR(wave->frequency, 2.7, 0.02);
  EXPECT_NEAR(wave->amplitude, 1.5, 0.15);
  EXPECT_NEAR(std::cos(wave->phase - 0.6), 1, 0.05);
  // The gain is that of the squares.
  double before = 0, after = 0;
  for (size_t i = 0; i < at.size(); ++i) {
    const double moved =
        weight[i] * wave->amplitude * std::sin(wave->frequency * at[i] + wave->phase);
    before += rest[i] * rest[i], after += std::pow(rest[i] + moved, 2);
  }
  EXPECT_NEAR(wave->gain, 0.5 * (before - after), 1e-6 * before);
}

TEST(WaveSearch, NeedsObservationsThatVary) {
  EXPECT_FALSE(strongest_wave(std::vector<double>(100, 2), std::vector<double>(100, 1),
                              std::vector<double>(100, 1)));
  EXPECT_FALSE(strongest_wave({1, 2, 3}, {1, 1, 1}, {0, 1, 0}));
}

}  // namespace
}  // namespace seam::measurement
