#include "measurement/plan/plan.h"

#include <gtest/gtest.h>

#include <cmath>

#include "measurement/numerics/regression.h"
#include "measurement/problem/made_problem.h"

namespace seam::measurement {
namespace {

constexpr double kPlanNoise = 0.3;

std::vector<double> evenly(size_t count) {
  std::vector<double> x;
  for (size_t i = 0; i < count; ++i) x.push_back(0.1 * static_cast<double>(i));
  return x;
}

// Intercept and slope of a line; the look at all of its parameters as refitted anyway.
EffectLook line_look(const MadeProblem& problem, size_t parameters, double repeats = 1) {
  const auto line =
      made_effect("line", {{.name = "a", .min = -9, .max = 9}, {.name = "b", .min = -9, .max = 9}});
  const Model model = made_model(line, {0.5, 2});
  std::vector<Unknown> unknowns;
  for (size_t i = 0; i < parameters; ++i) unknowns.push_back({"line", i});
  const Evaluation here = problem.evaluate(model, problem.all_groups());
  const Columns columns = columns_at(problem, model, unknowns, here);
  const std::vector<double> none(here.whitened.size(), 0);
  return look_of(problem, here, columns, none, parameters, repeats);
}

class MadeLine : public MadeProblem {
 public:
  explicit MadeLine(size_t count)
      : MadeProblem(evenly(count), kPlanNoise,
                    [](const std::vector<double>& p, double x) { return p[0] + p[1] * x; }) {
    take(std::vector<double>(count, 0));
  }
};

TEST(Plan, AMeanOfReadingsIsKnownByTheRootOfTheirNumber) {
  const MadeLine problem(64);
  EXPECT_NEAR(standard_errors(line_look(problem, 1))[0], kPlanNoise / 8, 1e-6);
  EXPECT_NEAR(standard_errors(line_look(problem, 1, 4))[0], kPlanNoise / 16, 1e-6);
}

TEST(Plan, ALineIsKnownAsItsFormulaSays) {
  const MadeLine problem(50);
  double sum = 0, sum2 = 0;
  for (const double x : problem.x()) sum += x, sum2 += x * x;
  const double n = 50, about_mean = sum2 - sum * sum / n;
  const std::vector<double> errors = standard_errors(line_look(problem, 2));
  EXPECT_NEAR(errors[0], kPlanNoise * std::sqrt(sum2 / (n * about_mean)), 1e-6);
  EXPECT_NEAR(errors[1], kPlanNoise / std::sqrt(about_mean), 1e-6);
}

// Values come from the groups that are not held out, as those that the tool states.
TEST(Plan, HeldOutGroupsGiveNoValues) {
  MadeLine problem(200);
  problem.deal_into(20);
  double fitted = 0;
  const Groups training = problem.training_groups();
  for (const char trains : training) fitted += trains ? 10 : 0;
  ASSERT_LT(fitted, 200);
  const EffectLook look = line_look(problem, 1);
  EXPECT_EQ(look.held.size(), 20 - static_cast<size_t>(fitted / 10));
  EXPECT_NEAR(standard_errors(look)[0], kPlanNoise / std::sqrt(fitted), 1e-6);
}

// One parameter with this information in each part, that moves residuals by one unit of it.
EffectLook one_parameter(const std::vector<double>& held, double trained) {
  const auto part = [](double information) {
    return PartInformation{Eigen::MatrixXd::Constant(1, 1, information),
                           Eigen::VectorXd::Constant(1, information)};
  };
  EffectLook look{.base = 0, .price = 8};
  for (const double information : held) look.held.push_back(part(information));
  if (trained > 0) look.trained = part(trained);
  return look;
}

// Half the square of a normal variable must be above the price, which has 95 % at 1.645 above it.
TEST(Plan, TheSmallestSizeFollowsFromThePrice) {
  const EffectLook look = one_parameter({0, 0, 0}, 1);
  EXPECT_NEAR(Detection(look).scale_found(100), std::sqrt(2 * look.price) + 1.645, 0.12);
  // Where what is left may be more than the noise by chance, ratios are worth less.
  EffectLook few = look;
  few.residuals = 200;
  EXPECT_GT(Detection(few).scale_found(100), 1.005 * Detection(look).scale_found(100));
  EXPECT_LT(Detection(few).scale_found(100), 1.1 * Detection(look).scale_found(100));
  EffectLook wide = look;
  wide.movement = {Eigen::MatrixXd::Constant(1, 1, 1e-6)};
  wide.material = 0.1;  // Predictions move by 1e-3 of the size.
  EXPECT_NEAR(Detection(wide).scale_found(1000), 100 + 1.645, 0.2);
  EXPECT_FALSE(std::isfinite(Detection(wide).scale_found(50)));
}

// The rules by hand, on means of readings.
TEST(Plan, TheChanceIsThatOfTheRulesOnMadeReadings) {
  const double trained = 70, held = 30, size = 0.5;
  const RandomStream stream{.seed = 5, .stream = 3};
  int found = 0;
  constexpr int kSets = 20'000;
  for (uint64_t set = 0; set < kSets; ++set) {
    const double mean = size + normal(stream.child("trained"), set) / std::sqrt(trained);
    const double other = size + normal(stream.child("held"), set) / std::sqrt(held);
    const double gain = held * (mean * other - 0.5 * mean * mean);
    found += 0.5 * trained * mean * mean + gain > 8 && gain > kUnluckyLoss;
  }
  const Detection detection(one_parameter({held}, trained));
  EXPECT_NEAR(detection.chance(size), static_cast<double>(found) / kSets, 0.025);
  EXPECT_LT(detection.chance(0.2), 0.2);
  EXPECT_GT(detection.chance(0.8), 0.99);
}

TEST(Plan, GroupsThatAreLeftOutInTurnCountOnceForValues) {
  const EffectLook look = one_parameter({25, 25, 25, 25}, 0);
  EXPECT_NEAR(standard_errors(look)[0], 0.1, 1e-9);
  EXPECT_NEAR(gain_of(look.whole(), 0), 50, 1e-9);
  const double found = Detection(look).scale_found(100);
  EXPECT_GT(found, 0.35);
  EXPECT_LT(found, 0.75);
}

TEST(Plan, APairIsApartWhereOneIsAheadByTheWidthOfATie) {
  const PairGains pair{.truth = 20, .other = 18};
  EXPECT_NEAR(pair.repeats_to_part(), kTieWidth / 2, 0.01);
  EXPECT_FALSE(std::isfinite(PairGains{.truth = 20, .other = 20}.repeats_to_part()));
}

}  // namespace
}  // namespace seam::measurement
