#include "scheduler/loop/clock.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace seam::scheduler {
namespace {

TEST(Clock, TicksAreOffsetPlusMultiplesNotARunningSum) {
  const Clock clock({.offset = SimDuration::from_ns(7), .period = SimDuration::from_ns(40'000'000)},
                    {});
  EXPECT_EQ(clock.tick(0).ns(), 7);
  EXPECT_EQ(clock.tick(1'000'000).ns(), 40'000'000'000'007);
}

TEST(Clock, DriftLengthensEveryPeriod) {
  const Clock clock({.period = SimDuration::from_ns(40'000'000), .drift = 50e-6}, {});
  // 50 ppm of 1,000 s is 50 ms.
  EXPECT_EQ(clock.tick(25'000).ns(), 1'000'050'000'000);
  // One period's part, 2,000 ns.
  EXPECT_EQ(clock.tick(1).ns(), 40'002'000);
}

TEST(Clock, JitterHasItsSpreadAndNoMemory) {
  const double sigma_s = 1e-3;
  const Clock clock({.offset = SimDuration::from_s(1),
                     .period = SimDuration::from_s(0.04),
                     .jitter_sigma_s = sigma_s},
                    {3, 4});
  const Clock again({.offset = SimDuration::from_s(1),
                     .period = SimDuration::from_s(0.04),
                     .jitter_sigma_s = sigma_s},
                    {3, 4});
  double sum = 0, sum_of_squares = 0;
  const int n = 20'000;
  for (int i = 0; i < n; ++i) {
    const double jitter_s = (clock.tick(i).ns() - (1'000'000'000 + i * 40'000'000ll)) * 1e-9;
    sum += jitter_s;
    sum_of_squares += jitter_s * jitter_s;
    ASSERT_EQ(clock.tick(i), again.tick(i));
  }
  // Five standard errors: one false alarm in a million.
  EXPECT_NEAR(sum / n, 0, 5 * sigma_s / std::sqrt(n));
  EXPECT_NEAR(sum_of_squares / n, sigma_s * sigma_s, 5 * sigma_s * sigma_s * std::sqrt(2.0 / n));
}

TEST(Clock, JitterKeepsTheOrderOfTicks) {
  const Clock clock({.period = SimDuration::from_s(0.008), .jitter_sigma_s = 0.02}, {1, 1});
  for (int i = 0; i < 10'000; ++i) ASSERT_LT(clock.tick(i), clock.tick(i + 1));
}

TEST(Clock, LockedTicksMeetTheCycleExactly) {
  const Clock clock({.offset = SimDuration::from_ns(5),
                     .period = SimDuration::from_ns(1'000'000'000),
                     .divisor = 7},
                    {});
  EXPECT_EQ(clock.tick(7 * 1'000'000).ns(), 1'000'000'000'000'005);
  EXPECT_EQ(clock.tick(1).ns(), 142'857'142 + 5);
}

TEST(Clock, FirstAtOrAfterAgreesWithSearch) {
  const Clock clock({.offset = SimDuration::from_s(0.013),
                     .period = SimDuration::from_s(0.04),
                     .drift = 3e-4,
                     .jitter_sigma_s = 2e-3},
                    {5, 6});
  for (int64_t ns = 0; ns < 3'000'000'000; ns += 7'654'321) {
    int64_t expected = 0;
    while (clock.tick(expected) < SimTime::from_ns(ns)) ++expected;
    ASSERT_EQ(clock.first_at_or_after(SimTime::from_ns(ns)), expected) << ns;
  }
}

}  // namespace
}  // namespace seam::scheduler
