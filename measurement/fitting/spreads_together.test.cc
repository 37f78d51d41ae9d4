// Two spreads that are told from each other along a valley alone: the variance of half of the data
// is a^2 + b^2, that of the other half a^2 + 0.8 b^2.
#include "measurement/fitting/spreads_together.h"

#include <gtest/gtest.h>

#include <cmath>

#include "measurement/problem/made_problem.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

class ValleyProblem : public Problem {
 public:
  ValleyProblem(size_t n, double a, double b) {
    facts_.channels = {{.name = "y"}};
    facts_.groups = {"all"};
    for (size_t i = 0; i < n; ++i) {
      facts_.line_of_row.push_back(static_cast<int>(i));
      facts_.group_of_row.push_back(0);
      facts_.row_of.push_back(static_cast<int>(i));
      facts_.time_of_row.push_back(static_cast<double>(i));
      facts_.channel_of.push_back(0);
      y_.push_back(sigma(a, b, i) * normal(RandomStream{.seed = 8}, i));
    }
  }
  Evaluation evaluate(const Model& model, const Groups& groups, const Evaluation*) const override {
    Evaluation out{.residual = y_};
    const auto values = model.effects().front().values();
    for (size_t i = 0; i < y_.size(); ++i) out.sigma.push_back(sigma(values[0], values[1], i));
    whiten_diagonal(*this, groups, out);
    return out;
  }
  void check_model(const Model&) const override {}

  // The mean square of each half, from which the best spreads follow in closed form.
  double mean_square(size_t half) const {
    double sum = 0;
    for (size_t i = half; i < y_.size(); i += 2) sum += y_[i] * y_[i];
    return sum / (0.5 * static_cast<double>(y_.size()));
  }

 private:
  static double sigma(double a, double b, size_t i) {
    return std::sqrt(a * a + (i % 2 ? 0.8 : 1) * b * b);
  }
  std::vector<double> y_;
};

TEST(SpreadsTogether, FindTheEndOfAValley) {
  const ValleyProblem problem(20000, 1, 2);
  const auto effect = made_effect("two",
                                  {{.name = "a", .min = 0, .max = 100, .scale = 1},
                                   {.name = "b", .min = 0, .max = 100, .scale = 1}},
                                  true);
  const Model start = made_model(effect, {2, 0.5});
  const ParameterSpace space(start, {{"two", 0}, {"two", 1}});
  const SpreadsTogether found =
      fit_spreads_together(problem, space, start, problem.all_groups(), nullptr);
  ASSERT_EQ(found.which.size(), 2u);
  const double even = problem.mean_square(0), odd = problem.mean_square(1);
  const double b2 = (even - odd) / 0.2, a2 = even - b2;
  EXPECT_NEAR(found.place[0], std::sqrt(a2), 0.02 * std::sqrt(a2));
  EXPECT_NEAR(found.place[1], std::sqrt(b2), 0.005 * std::sqrt(b2));
  // Errors by the delta method: a mean square of n values has the relative variance 2 / n.
  const double n = 10000;
  const double of_b2 = std::sqrt(2 / n * (even * even + odd * odd)) / 0.2;
  Fit fit = space.fit_at(start, found.place, 0, true);
  found.state(fit);
  EXPECT_TRUE(found.holds_at(found.log_likelihood - 0.01));
  EXPECT_FALSE(found.holds_at(found.log_likelihood - 1));
  // Again from there, with what was found as a guide: the same place and errors.
  const SpreadsTogether again = fit_spreads_together(problem, space, space.at(start, found.place),
                                                     problem.all_groups(), nullptr, &found);
  for (int i = 0; i < 2; ++i) {
    const double sigma = std::sqrt(found.covariance[static_cast<size_t>(3 * i)]);
    EXPECT_NEAR(again.place[i], found.place[i], 0.05 * sigma);
    EXPECT_NEAR(std::sqrt(again.covariance[static_cast<size_t>(3 * i)]), sigma, 0.1 * sigma);
  }
  EXPECT_NEAR(fit.sigma[1], of_b2 / (2 * std::sqrt(b2)), 0.1 * of_b2 / (2 * std::sqrt(b2)));
}

TEST(SpreadsTogether, LeaveSingleOnesAlone) {
  const ValleyProblem problem(100, 1, 2);
  const auto effect = made_effect("two",
                                  {{.name = "a", .min = 0, .max = 100, .scale = 1},
                                   {.name = "b", .min = 0, .max = 100, .scale = 1}},
                                  true);
  const Model start = made_model(effect, {2, 0});
  const ParameterSpace space(start, {{"two", 0}, {"two", 1}});
  EXPECT_TRUE(
      fit_spreads_together(problem, space, start, problem.all_groups(), nullptr).which.empty());
}

}  // namespace
}  // namespace seam::measurement
