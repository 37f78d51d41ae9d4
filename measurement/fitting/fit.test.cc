// A fit goes where the data tell it to, and nowhere else.
#include <gtest/gtest.h>

#include <cmath>

#include "measurement/problem/made_problem.h"

namespace seam::measurement {
namespace {

constexpr double kNoiseOfLine = 0.5;
constexpr size_t kRowsOfLine = 1000;

std::shared_ptr<const EffectDefinition> two_numbers() {
  return made_effect("line", {{.name = "level", .min = -1e9, .max = 1e9, .scale = 1},
                              {.name = "other", .min = -1e9, .max = 1e9, .scale = 1}});
}

// Seen of a level of 7 and another number of 0.
class TwoNumbers : public MadeProblem {
 public:
  explicit TwoNumbers(const Formula& formula)
      : MadeProblem(evenly(-1, 1, kRowsOfLine), kNoiseOfLine, formula) {
    observe(made_model(two_numbers(), {7, 0}), {.seed = 3, .stream = 1});
  }

  // From a level of 1 and another number of 3.
  Fit fitted() {
    const Model start = made_model(two_numbers(), {1, 3});
    prepare(start);
    return fit(start, {{"line", 0}, {"line", 1}}, all_groups());
  }
};

// The best slope of a line that all but lies flat is millions off, and gains half a unit.
TEST(Fit, StaysInWhatTheDataDoNotTell) {
  TwoNumbers line([](const std::vector<double>& p, double x) { return p[0] + 1e-8 * p[1] * x; });
  const Fit fit = line.fitted();
  EXPECT_TRUE(fit.converged);
  EXPECT_NEAR(fit.value[0], 7, 4 * kNoiseOfLine / std::sqrt(kRowsOfLine));
  EXPECT_NEAR(fit.value[1], 3, 0.05);
  EXPECT_GT(fit.sigma[1], 1e5);
}

// Each of the two is told beside the other held, their sum alone where both are free.
TEST(Fit, StaysAlongSumsThatTheDataDoNotTell) {
  TwoNumbers line(
      [](const std::vector<double>& p, double x) { return p[0] + p[1] * (1 + 1e-8 * x); });
  const Fit fit = line.fitted();
  EXPECT_TRUE(fit.converged);
  EXPECT_NEAR(fit.value[0] + fit.value[1], 7, 4 * kNoiseOfLine / std::sqrt(kRowsOfLine));
  EXPECT_NEAR(fit.value[1] - fit.value[0], 2, 0.1);
}

// Ten of its scales are little told, and are what the data say all the same.
TEST(Fit, GoesWhereTheDataTellALittle) {
  TwoNumbers line([](const std::vector<double>& p, double x) { return p[0] + 0.003 * p[1] * x; });
  const Fit fit = line.fitted();
  // The least squares by their closed form: evenly spread x have no mean.
  double xy = 0, xx = 0;
  for (size_t i = 0; i < kRowsOfLine; ++i)
    xy += 0.003 * line.x()[i] * line.y()[i], xx += std::pow(0.003 * line.x()[i], 2);
  EXPECT_NEAR(fit.value[1], xy / xx, 0.05 * fit.sigma[1]);
  EXPECT_NEAR(fit.sigma[1], kNoiseOfLine / std::sqrt(xx), 0.01 * fit.sigma[1]);
}

}  // namespace
}  // namespace seam::measurement
