// Gross errors that are put into noise, alone, in bursts and in bursts side by side, against where
// they were put.
#include <gtest/gtest.h>

#include <cmath>

#include "measurement/problem/made_problem.h"
#include "sim_core/base/maths.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr size_t kRows = 300;
constexpr double kNoise = 0.01;

class Constant : public MadeProblem {
 public:
  Constant()
      : MadeProblem(std::vector<double>(kRows), kNoise,
                    [](const std::vector<double>& p, double) { return p[0]; }) {}
};

std::vector<double> noise(uint64_t seed) {
  std::vector<double> y(kRows);
  for (size_t i = 0; i < kRows; ++i)
    y[i] = kNoise * normal(RandomStream{.seed = seed, .stream = 1}, i);
  return y;
}

std::vector<size_t> found_in(std::vector<double> y) {
  Constant problem;
  problem.take(std::move(y));
  const std::vector<char> outliers = problem.find_outliers(made_model(
      made_effect("constant", {{.name = "level", .min = -100, .max = 100, .scale = 1}}), {0}));
  std::vector<size_t> rows;
  for (size_t i = 0; i < kRows; ++i) {
    if (outliers[i]) rows.push_back(i);
  }
  return rows;
}

TEST(Outliers, BurstsSideBySideAreFoundWithoutWhatLiesBetween) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    std::vector<double> y = noise(seed);
    const std::vector<size_t> rows = {0,   1,   40,  100, 101, 102, 104, 105,
                                      106, 200, 201, 202, 203, 204, 205, 299};
    for (const size_t row : rows) y[row] += (row < 150 ? 30 : -30) * kNoise;
    EXPECT_EQ(found_in(y), rows) << "seed " << seed;
  }
}

TEST(Outliers, AMisfitThatDriftsHasNone) {
  for (const double rows_a_turn : {12.0, 30.0, 60.0, 150.0, 600.0}) {
    for (const double size : {1.0, 3.0, 10.0, 30.0}) {
      // Steeper than the noise from row to row it jumps, and neighbours say nothing.
      if (2 * maths::kPi * size / rows_a_turn > 2) continue;
      std::vector<double> y = noise(7);
      for (size_t i = 0; i < kRows; ++i)
        y[i] += size * kNoise * maths::sin(2 * maths::kPi * static_cast<double>(i) / rows_a_turn);
      EXPECT_TRUE(found_in(y).empty()) << size << " noises, " << rows_a_turn << " rows a turn";
    }
  }
}

// What was kept of predictions stays where marks do.
TEST(Outliers, MarksThatStandAreNoNewOnes) {
  Constant problem;
  std::vector<char> marks(kRows, 0);
  marks[3] = 1;
  problem.leave_out(marks);
  const int64_t times = problem.times_marked();
  problem.leave_out(marks);
  EXPECT_EQ(problem.times_marked(), times);
  problem.leave_out({});
  EXPECT_NE(problem.times_marked(), times);
}

}  // namespace
}  // namespace seam::measurement
