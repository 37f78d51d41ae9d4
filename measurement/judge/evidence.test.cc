// The evidence of an explanation against the integral that it stands for: likelihood times priors
// over all values, by brute force.
#include "measurement/judge/evidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "measurement/problem/made_problem.h"

namespace seam::measurement {
namespace {

constexpr double kNoiseOfValues = 0.5;
constexpr double kTypical = 0.3;

// y = a x + b (x + alike x^2): with `alike` near 0 two slopes that stand for each other.
class TwoSlopes : public MadeProblem {
 public:
  explicit TwoSlopes(double alike)
      : MadeProblem(evenly(-1, 1, 300), kNoiseOfValues,
                    [alike](const std::vector<double>& p, double x) {
                      return p[0] * x + (p.size() > 1 ? p[1] * (x + alike * x * x) : 0);
                    }) {
    deal_into(20);
  }
};

std::shared_ptr<const EffectDefinition> slope(const std::string& name) {
  return made_effect(name, {{.name = "size", .min = -50, .max = 50, .scale = kTypical}});
}

Model of(double a, double b) {
  Model model;
  model.set(slope("a"), {{.value = a}});
  model.set(slope("b"), {{.value = b}});
  return model;
}

Assessment fitted(const MadeProblem& problem, const Model& start,
                  const std::vector<Unknown>& unknowns) {
  const Fit fit = problem.fit(start, unknowns, problem.all_groups());
  return {.model = fit.model, .unknowns = unknowns, .fit = fit, .total_ll = fit.log_likelihood};
}

double log_prior(double value) {
  const double t = value / kTypical;
  return -std::log(std::numbers::pi * kTypical * (1 + t * t));
}

// ln of the integral of likelihood times priors over both values, within eight errors of the best.
double integral(const MadeProblem& problem, const Assessment& best) {
  constexpr double kReach = 8, kStep = 0.2;  // In errors.
  const std::vector<double>&value = best.fit.value, &sigma = best.fit.sigma;
  double sum = 0;
  for (double i = -kReach; i <= kReach; i += kStep) {
    for (double k = -kReach; k <= kReach; k += kStep) {
      const double a = value[0] + i * sigma[0], b = value[1] + k * sigma[1];
      const double ll = problem.score(of(a, b), problem.all_groups()).log_likelihood;
      sum += std::exp(ll - best.total_ll + log_prior(a) + log_prior(b));
    }
  }
  return best.total_ll + std::log(sum * kStep * kStep * sigma[0] * sigma[1]);
}

TEST(Evidence, IsTheIntegralOfLikelihoodTimesPriors) {
  // Of a value that is known well Laplace's integral over a prior of Cauchy is smaller by this.
  const double constant = 0.5 * std::log(2 / std::numbers::pi);
  for (const double size : {0.4, 3.0}) {
    TwoSlopes problem(1.5);
    problem.observe(of(size, 2 * size), {.seed = 4, .stream = 1});
    const Assessment best = fitted(problem, of(0.1, 0.1), {{"a", 0}, {"b", 0}});
    EXPECT_NEAR(best.total_ll + occam_factor(best) + 2 * constant, integral(problem, best), 0.15)
        << size;
  }
}

// Below the typical size every size is as likely: the price of a value is that of its own errors.
TEST(Evidence, WhatIsSmallIsNoRarer) {
  const effects::Parameter parameter{.name = "size", .min = -9, .max = 9, .scale = 2};
  EXPECT_EQ(prior_size(parameter, -5, 0.01), 2);
  EXPECT_EQ(prior_size(parameter, -0.5, 0.01), 0.5);
  EXPECT_EQ(prior_size(parameter, 0.01, 0.01), 3 * 0.01);
  EXPECT_EQ(prior_size(parameter, 0.01, 5), 2);
  EXPECT_EQ(distance_in_sizes(parameter, -0.5), -0.25);
}

// What the data do not tell apart is one value more in name only.
TEST(Evidence, TwoThatStandForEachOtherPayOnce) {
  constexpr double kInformation = 1e4;
  const Eigen::Matrix2d alike = Eigen::Matrix2d::Constant(kInformation);
  const Eigen::Matrix2d apart{{kInformation, 0}, {0, kInformation}};
  const Eigen::Vector2d typical(kTypical, kTypical);
  const double one = occam_factor(alike.topLeftCorner(1, 1), typical.head(1));
  EXPECT_NEAR(occam_factor(alike, typical), one - 0.5 * std::log(2.0), 1e-3);
  EXPECT_NEAR(occam_factor(apart, typical), 2 * one, 1e-9);
  EXPECT_EQ(occam_factor(Eigen::MatrixXd(), Eigen::VectorXd()), 0);
}

// A limit is seen by its reciprocal, in which it is absent at 0.
TEST(Evidence, ALimitIsAbsentAtInfinity) {
  const auto limit = made_effect("limit", {{.name = "most",
                                            .neutral = std::numeric_limits<double>::infinity(),
                                            .min = 0.1,
                                            .max = std::numeric_limits<double>::infinity(),
                                            .scale = 4,
                                            .fit_reciprocal = true}});
  const Model model = made_model(limit, {8});
  const double sigma = 0.5;
  const Assessment fit{
      .model = model,
      .unknowns = {{"limit", 0}},
      .fit = {.model = model, .value = {8}, .sigma = {sigma}, .covariance = {sigma * sigma}}};
  // Its reciprocal is 1/8 with an error of 0.5 / 64; typical is 1/4.
  const double known = std::pow(0.125 / (sigma / 64), 2);
  EXPECT_NEAR(occam_factor(fit), -0.5 * std::log1p(known) - std::log1p(0.25), 1e-9);
}

TEST(Evidence, OfInformationAsOfErrors) {
  const Eigen::Matrix2d information{{9, 2}, {2, 5}};
  const Eigen::Vector2d typical(0.5, 2);
  const Eigen::Matrix2d scaled{{9 * 0.25, 2}, {2, 5 * 4}};
  const double determinant = (Eigen::Matrix2d::Identity() + scaled).determinant();
  EXPECT_NEAR(occam_factor(information, typical), -0.5 * std::log(determinant), 1e-12);
}

}  // namespace
}  // namespace seam::measurement
