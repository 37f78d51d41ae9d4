#include "app/sweep/curve.h"

#include <cmath>

#include "app/sweep/sweep_testing.h"

namespace seam::app {
namespace {

// Student's t, chi-squared and Wilson's interval as printed in tables.
TEST(Curve, IntervalsAreThoseOfTables) {
  const std::vector<double> values = {1, 2, 3, 4, 5};
  const double s = std::sqrt(2.5);
  const Estimate mean = estimate_of(CurveStatistic::mean, values);
  EXPECT_DOUBLE_EQ(mean.value, 3);
  EXPECT_NEAR(*mean.high - 3, 2.7764 * s / std::sqrt(5), 1e-4);
  EXPECT_NEAR(3 - *mean.low, 2.7764 * s / std::sqrt(5), 1e-4);
  const Estimate deviation = estimate_of(CurveStatistic::deviation, values);
  EXPECT_DOUBLE_EQ(deviation.value, s);
  EXPECT_NEAR(*deviation.low, s * std::sqrt(4 / 11.1433), 1e-4);
  EXPECT_NEAR(*deviation.high, s * std::sqrt(4 / 0.484419), 1e-4);
  // Newcombe 1998, his case of 81 hits of 263: 0.2553 to 0.3662.
  std::vector<double> hits(263, 0);
  std::fill_n(hits.begin(), 81, 1);
  const Estimate rate = estimate_of(CurveStatistic::rate, hits);
  EXPECT_NEAR(*rate.low, 0.2553, 5e-5);
  EXPECT_NEAR(*rate.high, 0.3662, 5e-5);
}

// By counting: of all ways in which n values fall to either side of the median, those in which k of
// them or fewer lie on one side.
TEST(Curve, TheMediansIntervalLeavesOutAsManyAsItMay) {
  for (int n = 1; n <= 20; ++n) {
    std::vector<double> values;
    for (int i = 1; i <= n; ++i) values.push_back(i);
    double ways = 0, all = std::pow(2, n), choose = 1;
    int outside = 0;
    for (int k = 0; k < n / 2; ++k) {
      ways += choose;
      choose = choose * (n - k) / (k + 1);
      if (ways / all <= 0.025) outside = k + 1;
    }
    const Estimate median = estimate_of(CurveStatistic::median, values);
    EXPECT_DOUBLE_EQ(median.value, 0.5 * (n + 1));
    EXPECT_EQ(median.low.has_value(), outside > 0) << n;
    if (outside == 0) continue;
    EXPECT_EQ(*median.low, outside) << n;
    EXPECT_EQ(*median.high, n + 1 - outside) << n;
  }
}

TEST(Curve, FewValuesHaveNoInterval) {
  EXPECT_FALSE(estimate_of(CurveStatistic::mean, {4}).low.has_value());
  EXPECT_EQ(estimate_of(CurveStatistic::mean, {4}).value, 4);
  EXPECT_TRUE(std::isnan(estimate_of(CurveStatistic::deviation, {4}).value));
}

TEST(Curve, GroupsRunsByOneOrTwoParameters) {
  const PlanFolder folder(
      "vary:\n  - {path: \"robots[0].pose.x_m\", name: x, values: [0.1, 0.2]}\n"
      "  - {path: \"robots[0].camera.every_frame\", name: all, values: [true, false]}\n"
      "seeds: [1, 2]\nkeep: {values: [a]}");
  auto results = ResultsFile::for_writing(folder.path("r"), folder.plan(), {"1", "2", "3"}, {});
  for (uint64_t run = 0; run < 8; ++run) {
    RunRecord record{.run = run, .end = "finished", .fingerprint = "1"};
    record.kept = {static_cast<double>(run)};
    if (run == 7) record.kept = {std::nullopt};
    if (run == 6) record.error = "it failed";
    results.add(record);
  }
  const auto by_x = curve_of(results, CurveStatistic::mean, "a", "x", "");
  ASSERT_EQ(by_x.size(), 2);
  EXPECT_EQ(by_x[0].x, "0.1");
  EXPECT_EQ(by_x[0].count, 4);
  EXPECT_EQ(by_x[0].estimate.value, 1.5);
  EXPECT_EQ(by_x[1].count, 2);  // One failed, one has no value.
  const auto both = curve_of(results, CurveStatistic::mean, "a", "x", "all");
  ASSERT_EQ(both.size(), 3);
  EXPECT_EQ(both[1].by, "false");
  EXPECT_EQ(both[1].estimate.value, 2.5);
  EXPECT_THROW(curve_of(results, CurveStatistic::mean, "b", "x", ""), UsageError);
  EXPECT_THROW(curve_of(results, CurveStatistic::mean, "end", "x", ""), InputError);
}

}  // namespace
}  // namespace seam::app
