#include "measurement/report/figures_told.h"

#include <gtest/gtest.h>

#include <cmath>

#include "measurement/problem/made_problem.h"

namespace seam::measurement {
namespace {

// Has the quotient of two values as a figure.
class Quotient : public MadeProblem {
 public:
  Quotient() : MadeProblem({0, 1}, 1, [](const std::vector<double>&, double) { return 0.0; }) {}
  std::vector<Figure> figures(const Model& model) const override {
    const auto values = model.find("two")->values();
    return {{.name = "a / b", .value = values[0] / values[1]}};
  }
};

// By the formula for quotients: the square of the relative error is sa^2 + sb^2 - 2 sab, relative.
TEST(FiguresTold, ErrorsAreThoseOfTheFit) {
  const auto two = made_effect("two", {{.name = "a", .min = -10, .max = 10, .scale = 1},
                                       {.name = "b", .min = -10, .max = 4, .scale = 1}});
  Assessment assessment;
  assessment.model = made_model(two, {6, 4});  // The second one is at its bound.
  assessment.unknowns = {{"two", 0}, {"two", 1}};
  assessment.fit.value = {6, 4};
  assessment.fit.sigma = {0.3, 0.1};
  assessment.fit.covariance = {0.09, 0.018, 0.018, 0.01};
  const double relative2 = std::pow(0.3 / 6, 2) + std::pow(0.1 / 4, 2) - 2 * 0.018 / (6 * 4);
  const auto figures = figures_told(Quotient(), assessment);
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_DOUBLE_EQ(figures[0].value, 1.5);
  EXPECT_NEAR(figures[0].sigma, 1.5 * std::sqrt(relative2), 1e-4);
  // Errors that were widened afterwards count as they are told.
  assessment.fit.sigma = {0.6, 0.2};
  EXPECT_NEAR(figures_told(Quotient(), assessment)[0].sigma, 3 * std::sqrt(relative2), 1e-3);
  assessment.fit.sigma = {0.3, 0};
  EXPECT_NEAR(figures_told(Quotient(), assessment)[0].sigma, 0.3 / 4, 1e-6);
}

}  // namespace
}  // namespace seam::measurement
