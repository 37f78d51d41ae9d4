#include "measurement/kinds/imu/stamps.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr double kRate_hz = 200;

ImuStretch stamped(size_t count, double drift_ppm, double sigma_s, uint64_t seed) {
  const RandomStream stream = RandomStream{.seed = seed}.child("stamps");
  ImuStretch stretch;
  for (size_t i = 0; i < count; ++i)
    stretch.stamp_s.push_back(3 + static_cast<double>(i) / (kRate_hz * (1 + 1e-6 * drift_ppm)) +
                              sigma_s * normal(stream, i));
  return stretch;
}

TEST(Stamps, OfAFastClock) {
  for (const double drift_ppm : {-3000.0, -20.0, 0.0, 45000.0}) {
    for (const StampPart& part : stamps_of(stamped(4000, drift_ppm, 0, 1), 3, kRate_hz)) {
      EXPECT_NEAR(part.drift_ppm, drift_ppm, 1e-6);
      EXPECT_EQ(part.freedom, 0) << "even stamps say nothing of how they scatter";
    }
  }
}

// Errors that are stated are those by which estimates scatter.
TEST(Stamps, ThatScatter) {
  constexpr double kSigma_s = 2e-3, kDrift_ppm = 400;
  constexpr size_t kSeeds = 300;
  double drift_square = 0, variance = 0, variance_square = 0, freedom = 0;
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    for (const StampPart& part :
         stamps_of(stamped(1200, kDrift_ppm, kSigma_s, seed), 2, kRate_hz)) {
      const double off = part.drift_ppm - kDrift_ppm;
      drift_square += off * off / part.drift_variance / (2 * kSeeds);
      const double over = part.variance_s2 / (kSigma_s * kSigma_s);
      variance += over / (2 * kSeeds);
      variance_square += (over - 1) * (over - 1) * part.freedom / 2 / (2 * kSeeds);
      freedom = part.freedom;
    }
  }
  // Four errors of a mean of 600 squares, and of 600 variances of 200 values each.
  EXPECT_NEAR(drift_square, 1, 4 * std::sqrt(2.0 / 600));
  EXPECT_NEAR(variance, 1, 4 * std::sqrt(2.0 / (600 * freedom)));
  EXPECT_NEAR(variance_square, 1, 4 * std::sqrt(2.0 / 600));
}

}  // namespace
}  // namespace seam::measurement
