// Against ways that are drawn by themselves, of which those count that the counts allow.
#include "measurement/kinds/odometry/rolled_way.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr double kJolt = 40, kStep_s = 0.1;

TEST(RolledWays, AreThoseOfAllWaysThatTheCountsAllow) {
  constexpr size_t kRows = 3;
  const CountedWay counted{.time_s = {0, 0.1, 0.2}, .ticks = {0, 1, 3}};
  const RolledWay way(counted, std::vector<double>(kRows, kJolt));
  // Each row is so many small pushes after the one before.
  constexpr int kDraws = 1'000'000, kPushes = 4;
  // As the class begins: a way anywhere about 0, and a speed as large as the fastest, 3 in a row.
  const RandomStream random{5, 0};
  uint64_t drawn = 0;
  int n = 0;
  std::array<double, kRows> sum{};
  std::array<std::array<double, kRows>, kRows> products{};
  for (int draw = 0; draw < kDraws; ++draw) {
    std::array<double, kRows> rolled;
    double at = uniform(random, drawn++) - 0.5, speed = 30 * normal(random, drawn++);
    const double start_weight = std::exp(-0.5 * at * at);
    if (uniform(random, drawn++) > start_weight) continue;
    rolled[0] = at;
    bool allowed = true;
    for (size_t k = 1; k < kRows && allowed; ++k) {
      for (int push = 0; push < kPushes; ++push) {
        const double dt_s = kStep_s / kPushes;
        const double change = std::sqrt(kJolt * dt_s) * normal(random, drawn++);
        at += (speed + 0.5 * change) * dt_s;
        speed += change;
      }
      rolled[k] = at;
      allowed = std::abs(at - counted.ticks[k]) < 0.5;
    }
    if (!allowed) continue;
    ++n;
    for (size_t k = 0; k < kRows; ++k) {
      sum[k] += rolled[k];
      for (size_t i = 0; i < kRows; ++i) products[k][i] += rolled[k] * rolled[i];
    }
  }
  ASSERT_GT(n, 3000);
  Eigen::Matrix2d P = way.at_start();
  for (size_t k = 0; k < kRows; ++k) {
    double with_before = 0;
    if (k > 0) {
      const RolledWay::Step step = way.step(counted.time_s[k - 1], counted.time_s[k]);
      with_before = (step.kept * P)(0, 0);
      P = step.kept * P * step.kept.transpose() + step.fresh;
    }
    const double mean = sum[k] / n, variance = products[k][k] / n - mean * mean;
    EXPECT_NEAR(way.mean()[k], mean, 0.02) << k;
    EXPECT_NEAR(P(0, 0), variance, 0.15 * variance) << k;  // By normal errors, not by bounds.
    if (k == 0) continue;
    const double covariance = products[k][k - 1] / n - mean * sum[k - 1] / n;
    EXPECT_NEAR(with_before, covariance, 0.15 * variance) << k;
  }
}

// Between rows the same as in one.
TEST(RolledWays, GoOnInParts) {
  const CountedWay counted{.time_s = {0, 0.1, 0.2, 0.4}, .ticks = {0, 2, 3, 3}};
  const RolledWay way(counted, kJolt);
  const RolledWay::Step whole = way.step(0.05, 0.5), a = way.step(0.05, 0.13),
                        b = way.step(0.13, 0.5);
  EXPECT_LT((whole.kept - b.kept * a.kept).norm(), 1e-9);
  EXPECT_LT((whole.fresh - b.kept * a.fresh * b.kept.transpose() - b.fresh).norm(), 1e-9);
}

// What never changes its speed may begin anywhere within its tick, however many rows it is seen in:
// no errors of so many rows that average out.
TEST(RolledWays, BeginAnywhereWithinATick) {
  CountedWay counted;
  for (int k = 0; k < 200; ++k) {
    counted.time_s.push_back(0.1 * k);
    counted.ticks.push_back(0);
  }
  const RolledWay way(counted, std::vector<double>(200, 1e-12));
  EXPECT_NEAR(way.at_start()(0, 0), 1.0 / 12, 0.01);
}

// A wheel that speeds up and slows down: counts tell it to far less than a tick, and what is left
// goes neither with the way nor beyond what is said of it.
TEST(RolledWays, AreKnownAsWellAsTheySay) {
  std::vector<CountedWay> counted;
  const auto rolled = [](int run, double t) {
    return 20 * t + 15 * std::sin(0.9 * t + run) + 4 * std::sin(2.3 * t + 2 * run) + 0.37 * run;
  };
  for (int run = 0; run < 8; ++run) {
    CountedWay way;
    for (int k = 0; k < 400; ++k) {
      way.time_s.push_back(0.05 * k);
      way.ticks.push_back(std::round(rolled(run, 0.05 * k)));
    }
    counted.push_back(way);
  }
  const double jolt = jolt_of(counted);
  double errors2 = 0, over_stated2 = 0, with_speed = 0, counts_with_speed = 0;
  int n = 0;
  for (int run = 0; run < 8; ++run) {
    const CountedWay& way = counted[static_cast<size_t>(run)];
    const RolledWay found(way, jolt);
    Eigen::Matrix2d P = found.at_start();
    for (size_t k = 0; k + 1 < 400; ++k) {
      if (k > 0) {
        const RolledWay::Step step = found.step(way.time_s[k - 1], way.time_s[k]);
        P = step.kept * P * step.kept.transpose() + step.fresh;
      }
      const double truth = rolled(run, way.time_s[k]), error = truth - found.mean()[k];
      errors2 += error * error;
      over_stated2 += error * error / P(0, 0);
      with_speed += error * (found.mean()[k + 1] - found.mean()[k]);
      counts_with_speed += (truth - way.ticks[k]) * (way.ticks[k + 1] - way.ticks[k]);
      ++n;
    }
  }
  EXPECT_LT(std::sqrt(errors2 / n), 0.15);  // Of a count alone 0.29.
  EXPECT_GT(over_stated2 / n, 0.5);
  EXPECT_LT(over_stated2 / n, 1.3);
  EXPECT_GT(counts_with_speed / n, 0.06);
  EXPECT_LT(std::abs(with_speed / n), 0.02);
}

}  // namespace
}  // namespace seam::measurement
