// Statistics of runs against closed forms, and their errors against as many other runs.
#include "measurement/kinds/outcomes/run_statistics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/error.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

double of(const std::string& name, const std::vector<double>& values) {
  return RunStatistic::named(name).of(values);
}

TEST(RunStatistics, AreThoseOfTheirNames) {
  const std::vector<double> values = {3, -4, 0, 1};
  EXPECT_DOUBLE_EQ(of("mean", values), 0);
  EXPECT_DOUBLE_EQ(of("spread", values), std::sqrt(26.0 / 3));
  EXPECT_DOUBLE_EQ(of("rms", values), std::sqrt(26.0 / 4));
  EXPECT_DOUBLE_EQ(of("min", values), -4);
  EXPECT_DOUBLE_EQ(of("max", values), 3);
  EXPECT_DOUBLE_EQ(of("largest", values), 4);
  EXPECT_DOUBLE_EQ(of("median", values), 0.5);
  EXPECT_DOUBLE_EQ(of("rate", values), 0.75);
  EXPECT_DOUBLE_EQ(of("quantile_0.75", values), 1.5);
  EXPECT_THROW(RunStatistic::named("meen"), InputError);
  EXPECT_THROW(RunStatistic::named("quantile_2"), InputError);
}

// Runs of settings that lie far apart, and noise of 0.1 about each.
std::vector<std::vector<double>> table(uint64_t seed, size_t settings, size_t alike) {
  std::vector<std::vector<double>> runs;
  for (size_t i = 0; i < settings * alike; ++i) {
    const RandomStream stream = RandomStream{.seed = seed}.child(i);
    const double common = 0.1 * normal(stream, 0);
    runs.push_back({static_cast<double>(i / alike) + common, common + 0.1 * normal(stream, 1)});
  }
  return runs;
}

TEST(RunStatistics, ErrorsAreThoseOfOtherRunsWithTheSameSettings) {
  const std::vector<ColumnStatistic> wanted = {{0, RunStatistic::named("mean")},
                                               {0, RunStatistic::named("rms")},
                                               {1, RunStatistic::named("mean")}};
  constexpr int kTables = 300;
  Eigen::MatrixXd told = Eigen::MatrixXd::Zero(3, 3), values(kTables, 3);
  for (int i = 0; i < kTables; ++i) {
    const StatisticsOfRuns one = statistics_of(table(static_cast<uint64_t>(i), 8, 3), 3, wanted);
    told += one.covariance / kTables;
    for (int k = 0; k < 3; ++k) values(i, k) = one.value[static_cast<size_t>(k)];
  }
  const Eigen::MatrixXd centred = values.rowwise() - values.colwise().mean();
  const Eigen::MatrixXd seen = centred.transpose() * centred / (kTables - 1);
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b)
      EXPECT_NEAR(told(a, b), seen(a, b), 0.25 * std::sqrt(seen(a, a) * seen(b, b))) << a << b;
  }
}

TEST(RunStatistics, MissingValuesAreLeftOutAndTooManyLeaveNothing) {
  const double nothing = std::nan("");
  const std::vector<ColumnStatistic> wanted = {{0, RunStatistic::named("mean")}};
  EXPECT_DOUBLE_EQ(statistics_of({{1}, {nothing}, {3}}, 1, wanted).value[0], 2);
  EXPECT_TRUE(std::isnan(statistics_of({{1}, {nothing}, {nothing}}, 1, wanted).value[0]));
}

TEST(RunStatistics, ARateOfNoneIsNotKnownToBeNone) {
  const std::vector<std::vector<double>> runs(12, std::vector<double>{0});
  const StatisticsOfRuns one = statistics_of(runs, 1, {{0, RunStatistic::named("rate")}});
  EXPECT_DOUBLE_EQ(one.value[0], 0);
  // Variance of a Beta(1, 13).
  EXPECT_NEAR(one.covariance(0, 0), 13.0 / (14 * 14 * 15), 1e-12);
}

}  // namespace
}  // namespace seam::measurement
