#include "measurement/sets/spline.h"

#include <gtest/gtest.h>

#include <cmath>

namespace seam::measurement {
namespace {

TEST(Spline, IsExactForCubics) {
  const auto cubic = [](double t) { return 2 + t * (-1 + t * (0.5 - 0.25 * t)); };
  std::vector<double> times, values;
  for (const double t : {0.0, 0.3, 0.9, 1.0, 1.7, 2.5})
    times.push_back(t), values.push_back(cubic(t));
  const Spline spline(times, values);
  for (double t = 0.01; t < 2.5; t += 0.07) {
    EXPECT_NEAR(spline.value(t), cubic(t), 1e-12);
    EXPECT_NEAR(spline.rate(t), -1 + t * (1 - 0.75 * t), 1e-11);
  }
}

// A head that swings at 1 Hz by 1 rad, logged each 8 ms.
TEST(Spline, FollowsASwingingHead) {
  std::vector<double> times, values;
  for (int i = 0; i < 300; ++i)
    times.push_back(0.008 * i), values.push_back(std::sin(2 * 3.14159265358979 * 0.008 * i));
  const Spline spline(times, values);
  for (double t = 0.05; t < 2.3; t += 0.0013)
    EXPECT_NEAR(spline.value(t), std::sin(2 * 3.14159265358979 * t), 2e-7);
}

TEST(Spline, GapsAreCrossedInAStraightLine) {
  const Spline spline({0, 1, 2, 12, 13, 14}, {0, 1, 4, 100, 81, 64}, 3);
  EXPECT_NEAR(spline.value(7), 52, 1e-12);
}

}  // namespace
}  // namespace seam::measurement
