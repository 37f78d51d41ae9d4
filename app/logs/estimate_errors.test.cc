#include "app/logs/estimate_errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace seam::app {
namespace {

TEST(EstimateErrors, SummariesAreThoseOfTheirDefinitions) {
  const ErrorSummary even = summarise({-3, 1, 2, -4});
  EXPECT_EQ(even.count, 4u);
  EXPECT_DOUBLE_EQ(even.mean, -1);
  EXPECT_DOUBLE_EQ(even.rms, std::sqrt(30.0 / 4));
  EXPECT_DOUBLE_EQ(even.median_abs, 2.5);
  EXPECT_DOUBLE_EQ(even.p90_abs, 4);
  EXPECT_DOUBLE_EQ(even.max_abs, 4);
  std::vector<double> ten;
  for (int i = 1; i <= 10; ++i) ten.push_back(i % 2 == 0 ? i : -i);
  EXPECT_DOUBLE_EQ(summarise(ten).p90_abs, 9);
  EXPECT_DOUBLE_EQ(summarise({-7}).median_abs, 7);
  EXPECT_EQ(summarise({}).count, 0u);
}

}  // namespace
}  // namespace seam::app
