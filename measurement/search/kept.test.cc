// A trace that moves a value by many of its errors stays in the model; sizes by formulas.
#include "measurement/search/kept.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "measurement/problem/made_problem.h"

namespace seam::measurement {
namespace {

constexpr double kKeptNoise = 0.5, kKeptLevel = 3;
constexpr size_t kKeptRows = 40'000;

std::shared_ptr<const EffectDefinition> kept_slope() {
  return made_effect("slope", {{.name = "size", .min = -100, .max = 100, .scale = 1}});
}

// y = level + size * x, x from 0 to 1: a level without the slope is size / 2 off. Found without it,
// with it as a trace.
SearchResult found_beside_slope(double size) {
  MadeProblem problem(
      evenly(0, 1, kKeptRows), kKeptNoise,
      [](const std::vector<double>& p, double x) { return p[0] + (p.size() > 1 ? p[1] * x : 0); });
  problem.deal_into(20);
  Model truth = made_model(
      made_effect("line", {{.name = "level", .min = -100, .max = 100, .scale = 1}}), {kKeptLevel});
  SearchResult result{.material = 0.1};
  const Model given = truth;
  truth.set(kept_slope(), {{.value = size}});
  problem.observe(truth, {.seed = 4});
  result.best.assessment = assess(problem, given, {{"line", 0}});
  const Looks looks = look_at(problem, result.best, {kept_slope()}, result.material);
  result.last_traces = traces_of(looks.candidates);
  EXPECT_EQ(result.last_traces.size(), 1u);
  keep_traces(problem, looks.tried, result);
  return result;
}

TEST(KeptTraces, WhatMovesAValueByManyErrorsIsKept) {
  const SearchResult result = found_beside_slope(0.1);
  ASSERT_EQ(result.kept.size(), 1u);
  EXPECT_EQ(result.kept[0].effect, "slope");
  EXPECT_EQ(result.kept[0].value, (Unknown{"line", 0}));
  // Half of 0.1, over 0.5 / sqrt(28,000) where 14 of 20 groups are fitted, and by its own noise.
  EXPECT_NEAR(result.kept[0].errors, 0.05 / (kKeptNoise / std::sqrt(0.7 * kKeptRows)), 4);
  const Assessment& best = result.best.assessment;
  EXPECT_NEAR(best.model.find("line")->values()[0], kKeptLevel, 4 * best.fit.sigma[0]);
  EXPECT_NEAR(best.model.find("slope")->values()[0], 0.1, 4 * best.fit.sigma[1]);
}

TEST(KeptTraces, WhatMovesItByAFewIsNot) {
  const SearchResult result = found_beside_slope(0.04);
  EXPECT_TRUE(result.kept.empty());
  EXPECT_FALSE(result.best.assessment.model.has("slope"));
}

TEST(KeptTraces, TheWorstValueIsNamed) {
  Assessment without, with;
  without.unknowns = {{"a", 0}, {"a", 1}, {"b", 0}};
  without.fit.value = {1, 2, 3};
  without.fit.sigma = {0.1, 0.1, std::numeric_limits<double>::infinity()};
  with.unknowns = {{"a", 0}, {"b", 0}, {"c", 0}, {"a", 1}};
  with.fit.value = {1.2, 90, 5, 1.6};
  const Moved most = most_moved(without, with);
  EXPECT_EQ(most.value, (Unknown{"a", 1}));
  EXPECT_NEAR(most.errors, 4, 1e-9);
}

}  // namespace
}  // namespace seam::measurement
