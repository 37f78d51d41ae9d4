#include "tools/workbench/look/climb.h"

#include <gtest/gtest.h>

#include <cmath>

namespace seam::tools {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

measurement::Box square(double half) {
  return {Vector2d(-half, -half), Vector2d(half, half)};
}

TEST(Climb, ComesCloseToAHillInFewLooks) {
  int looks = 0;
  const auto hill = [&](const VectorXd& at) {
    ++looks;
    return -std::pow(at[0] - 3, 2) - std::pow(at[1] + 0.2, 2);
  };
  const Climbed found = climb(hill, Vector2d(0.1, 0.1), Vector2d(0.1, 0.1), square(9), 40);
  EXPECT_NEAR(found.place[0], 3, 0.3);
  EXPECT_NEAR(found.place[1], -0.2, 0.1);
  EXPECT_NEAR(found.height, hill(found.place), 1e-12);
  EXPECT_LE(looks, 41);
}

TEST(Climb, StaysInsideItsBounds) {
  const auto slope = [](const VectorXd& at) { return at[0] - at[1]; };
  const Climbed found = climb(slope, Vector2d(0, 0), Vector2d(0.1, 0.1), square(1), 60);
  EXPECT_NEAR(found.place[0], 1, 1e-6);
  EXPECT_NEAR(found.place[1], -1, 1e-6);
}

TEST(Climb, StaysWhereNothingIsHigher) {
  const auto cone = [](const VectorXd& at) { return -at.norm(); };
  const Climbed found = climb(cone, Vector2d(0, 0), Vector2d(1, 1), square(5), 20);
  EXPECT_EQ(found.place.norm(), 0);
  // Where a value cannot be predicted at all, as well.
  const auto nowhere = [](const VectorXd&) { return -INFINITY; };
  EXPECT_EQ(climb(nowhere, Vector2d(2, 2), Vector2d(1, 1), square(5), 9).place, Vector2d(2, 2));
}

}  // namespace
}  // namespace seam::tools
