// The split into training and held-out groups over drawn sets of regimes.
#include "measurement/problem/regimes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "measurement/sets/set.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

std::vector<std::string> names(size_t count, size_t first = 0) {
  std::vector<std::string> all;
  for (size_t i = 0; i < count; ++i) all.push_back(std::to_string(first + i));
  return all;
}

size_t on_side(const Groups& held, const Groups& shows, bool is_held) {
  size_t count = 0;
  for (size_t g = 0; g < held.size(); ++g) count += shows[g] && (held[g] != 0) == is_held;
  return count;
}

TEST(Regimes, AThirdIsHeldOutAndOfEachRegimeAPartStandsOnBothSides) {
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    const RandomStream draw{.seed = seed, .stream = 1};
    const size_t count = 12 + static_cast<size_t>(20 * uniform(draw, 0));
    // Each group has one of three levels, and one in three shows something more.
    std::vector<Groups> regimes(4, Groups(count, 0));
    for (size_t g = 0; g < count; ++g) {
      regimes[static_cast<size_t>(3 * uniform(draw, 2 * g + 1))][g] = 1;
      regimes[3][g] = uniform(draw, 2 * g + 2) < 0.33;
    }
    const Groups held = held_out_of_each(names(count, seed), regimes);
    EXPECT_EQ(std::count(held.begin(), held.end(), 1),
              static_cast<long>(std::ceil(0.3 * static_cast<double>(count))));
    for (const Groups& regime : regimes) {
      const auto shown = std::count(regime.begin(), regime.end(), 1);
      EXPECT_EQ(on_side(held, regime, false) > 0, shown > 0) << seed;
      EXPECT_EQ(on_side(held, regime, true) > 0, shown > 1) << seed;
    }
  }
}

TEST(Regimes, WhatTheHashDividesStaysAsItIs) {
  const std::vector<std::string> groups = names(20);
  const Groups by_hash = held_out_groups(groups);
  EXPECT_EQ(held_out_of_each(groups, {}), by_hash);
  EXPECT_EQ(held_out_of_each(groups, {Groups(20, 1), Groups(20, 0)}), by_hash);
}

// What one group alone shows is found among very many.
TEST(Regimes, AGroupAmongAHundredThousandIsExchanged) {
  const std::vector<std::string> groups = names(100'000);
  const Groups by_hash = held_out_groups(groups);
  const auto alone = static_cast<size_t>(std::ranges::find(by_hash, 1) - by_hash.begin());
  Groups shows(groups.size(), 0);
  shows[alone] = 1;
  Groups expected = by_hash;
  expected[alone] = 0;
  expected[static_cast<size_t>(std::ranges::find(by_hash, 0) - by_hash.begin())] = 1;
  EXPECT_EQ(held_out_of_each(groups, {shows}), expected);
}

TEST(Regimes, WhereNotAllCanBeMetAllTrain) {
  // Twenty levels of two groups each, of which twelve can be held out.
  std::vector<Groups> regimes;
  for (size_t level = 0; level < 20; ++level) {
    regimes.emplace_back(40, 0);
    regimes.back()[2 * level] = regimes.back()[2 * level + 1] = 1;
  }
  const Groups held = held_out_of_each(names(40), regimes);
  size_t shown = 0;
  for (const Groups& regime : regimes) {
    EXPECT_GE(on_side(held, regime, false), 1u);
    shown += on_side(held, regime, true);
  }
  EXPECT_EQ(shown, 12u);
}

TEST(Regimes, LabelsAndSignsOfInputsAreRegimes) {
  Facts facts;
  facts.groups = {"a", "b"};
  facts.group_of_row = {0, 0, 1};
  facts.line_of_row = {1, 2, 3};
  const auto add = [&](Covariate::Type type, bool measured) {
    facts.covariates.push_back(
        {.name = "x", .type = type, .values = {0, -1, 1}, .of_measured = measured});
  };
  add(Covariate::Type::smooth, false), add(Covariate::Type::sign, true);
  EXPECT_TRUE(regimes_of_labels(facts).empty());
  add(Covariate::Type::sign, false);
  EXPECT_EQ(regimes_of_labels(facts), (std::vector<Groups>{{1, 0}, {0, 1}}));
  facts.covariates.clear();
  // Labels that number the rows.
  add(Covariate::Type::category, false);
  EXPECT_TRUE(regimes_of_labels(facts).empty());
  facts.covariates[0].values = {0, 1, 1};
  EXPECT_EQ(regimes_of_labels(facts), (std::vector<Groups>{{1, 0}, {1, 1}}));
}

}  // namespace
}  // namespace seam::measurement
