#include "measurement/search/choice.h"

#include <gtest/gtest.h>

#include <cmath>

#include "measurement/fitting/assess.h"
#include "measurement/problem/made_problem.h"

namespace seam::measurement {
namespace {

constexpr double kNoiseOfLine = 0.1;

std::shared_ptr<const EffectDefinition> effect_of(const std::string& name) {
  return made_effect(name, {{.name = "size", .min = -100, .max = 100, .scale = 1}});
}

// y = slope x + level + alike, where the last is nearly another slope.
TEST(Without, TheRestTakesOverWhatTheEffectStoodFor) {
  std::vector<double> x;
  for (int i = 0; i < 400; ++i) x.push_back(0.01 * i);
  MadeProblem problem(x, kNoiseOfLine, [](const std::vector<double>& p, double at) {
    const double alike = p.size() > 2 ? p[2] : 0;
    return p[0] * at + p[1] + alike * (at + 0.01 * std::sin(9 * at));
  });
  Model truth;
  truth.set(effect_of("slope"), {{.value = 3}});
  truth.set(effect_of("level"), {{.value = 1}});
  truth.set(effect_of("alike"), {{.value = 0}});
  problem.observe(truth, RandomStream{3, 1});
  const std::vector<Unknown> unknowns = {{"slope", 0}, {"level", 0}, {"alike", 0}};
  const Grown grown{.added = {"slope", "level", "alike"},
                    .assessment = assess(problem, truth, unknowns)};
  const Fit& fit = grown.assessment.fit;
  ASSERT_GT(std::abs(fit.value[2]), 0.01);
  const auto slope_in = [](const Grown& less) {
    EXPECT_FALSE(less.assessment.model.has("alike"));
    return less.assessment.model.find("slope")->value("size");
  };
  EXPECT_EQ(slope_in(without(grown, "alike")), fit.value[0]);
  const Grown less = without_at_best(problem, grown, "alike");
  EXPECT_NEAR(slope_in(less), 3, 0.02);
  // The model is a line: where the covariance leads, the fit of the rest ends.
  const Assessment again = assess(problem, less.assessment.model, less.assessment.unknowns);
  EXPECT_NEAR(slope_in(less), again.model.find("slope")->value("size"), 1e-3);
  // What has nothing to do with it stays.
  EXPECT_EQ(less.assessment.model.find("level")->value("size"), fit.value[1]);
}

}  // namespace
}  // namespace seam::measurement
