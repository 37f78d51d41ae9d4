#include "tools/experiments/head_swing/swing_theory.h"

#include <gtest/gtest.h>

#include <cmath>

namespace seam::tools {
namespace {

constexpr Swing kSwing{.amplitude_rad = 1.5, .period_s = 4};

TEST(SwingTheory, FourFramesASwingSeeThreeAnglesOrTwo) {
  const auto at_middle = locked_angles(kSwing, 4, 0);
  ASSERT_EQ(at_middle.size(), 4u);
  EXPECT_NEAR(at_middle[0], 0, 1e-12);
  EXPECT_NEAR(at_middle[1], 1.5, 1e-12);
  EXPECT_NEAR(at_middle[2], 0, 1e-12);
  EXPECT_NEAR(at_middle[3], -1.5, 1e-12);
  const auto between = locked_angles(kSwing, 4, 0.5);
  for (const double angle : between) EXPECT_NEAR(std::abs(angle), 1.5 * std::sqrt(0.5), 1e-12);
}

TEST(SwingTheory, CountsViewsThatHoldALandmark) {
  EXPECT_EQ(locked_views(kSwing, 4, 0, 0, 0.5), 2);    // Straight ahead: both passes.
  EXPECT_EQ(locked_views(kSwing, 4, 0, 1.2, 0.5), 1);  // Near the left end: once.
  EXPECT_EQ(locked_views(kSwing, 4, 0, 3.0, 0.5), 0);  // Behind: never.
  // Many frames: the share of a swing in which the landmark is seen.
  const double share = 2 * std::asin(0.5 / 1.5) / M_PI;
  EXPECT_NEAR(locked_views(kSwing, 100000, 0.3, 0, 0.5) / 100000.0, share, 1e-4);
}

TEST(SwingTheory, RateIsTheDerivativeOfTheAngle) {
  for (const double t : {0.0, 0.7, 1.9, 3.3}) {
    EXPECT_NEAR(kSwing.rate_radps(t), (kSwing.pan_rad(t + 1e-6) - kSwing.pan_rad(t - 1e-6)) / 2e-6,
                1e-6);
  }
}

TEST(SwingTheory, ARowReadLateIsAsIfTheHeadStoodBack) {
  // Turning left at 2 rad/s a row 20 ms late: the true pan is 0.04 rad further left than believed.
  const double t = 0.4;
  const Swing slow{.amplitude_rad = 1.5, .period_s = 40};
  const double late_s = 0.02;
  EXPECT_NEAR(stamp_bearing_error_rad(slow.rate_radps(t), late_s),
              slow.pan_rad(t) - slow.pan_rad(t + late_s), 1e-5);
  EXPECT_LT(stamp_bearing_error_rad(2, late_s), 0);
  EXPECT_GT(stamp_bearing_error_rad(-2, late_s), 0);
}

TEST(SwingTheory, RepeatedViewsAverageOnlyWhatIsNewInThem) {
  EXPECT_DOUBLE_EQ(locked_bias({.common = 3, .view = 4, .frame = 0}, 1, 7), 5);
  EXPECT_DOUBLE_EQ(locked_bias({.common = 0, .view = 4, .frame = 0}, 4, 7), 2);
  EXPECT_DOUBLE_EQ(locked_bias({.common = 0, .view = 0, .frame = 6}, 4, 9), 1);
}

}  // namespace
}  // namespace seam::tools
