#include "measurement/search/choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "measurement/fitting/assess.h"
#include "measurement/problem/made_problem.h"
#include "measurement/search/order.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr double kNoiseOfLine = 0.1;

std::shared_ptr<const EffectDefinition> effect_of(const std::string& name) {
  return made_effect(name, {{.name = "size", .min = -100, .max = 100, .scale = 1}});
}

// What does nothing where a fit of all left it needs no fits of its own to go.
TEST(Prune, WhatIsIdleGoesWithOneFit) {
  struct Counted : MadeProblem {
    using MadeProblem::MadeProblem;
    Fit fit(const Model& start, const std::vector<Unknown>& unknowns,
            const Groups& groups) const override {
      ++fits;
      return MadeProblem::fit(start, unknowns, groups);
    }
    mutable int fits = 0;
  };
  Counted problem(evenly(0, 4, 400), kNoiseOfLine, [](const std::vector<double>& p, double at) {
    double y = p[0] * at;
    for (size_t k = 1; k < p.size(); ++k) y += p[k] * std::sin(static_cast<double>(7 * k) * at);
    return y;
  });
  Model truth;
  truth.set(effect_of("slope"), {{.value = 3}});
  problem.observe(truth, RandomStream{3, 1});
  Grown grown{.added = {"slope"}, .assessment = assess(problem, truth, {{"slope", 0}})};
  for (const std::string name : {"a", "b", "c", "d"}) {
    grown.assessment.model.set(effect_of(name), {{.value = 0}});
    grown.assessment.unknowns.push_back({name, 0});
    grown.added.push_back(name);
  }
  problem.fits = 0;
  EXPECT_TRUE(prune(problem, effect_of, 1, kMaterial, grown));
  EXPECT_EQ(grown.added, std::vector<std::string>{"slope"});
  EXPECT_LE(problem.fits, 2);
}

// y = size * cos(x - phase) beside a slope.
struct Swing : MadeProblem {
  Swing()
      : MadeProblem(evenly(0, 12, 600), 0.1, [](const std::vector<double>& p, double at) {
          const double swing = p.size() > 2 ? p[1] * std::cos(at - p[2]) : 0;
          return p[0] * at + swing;
        }) {
    deal_into(10);
  }
};

Model swinging(double size, double phase) {
  const auto swing = made_effect("swing", {{.name = "size", .min = -9, .max = 9, .scale = 0.1},
                                           {.name = "phase", .min = -9, .max = 9, .scale = 0.3}});
  Model model;
  model.set(effect_of("slope"), {{.value = 3}});
  model.set(swing, {{.value = size}, {.value = phase}});
  return model;
}

// The errors that the user sees decide, and a phase says nothing of an amplitude that is 0.
TEST(IsAtNeutral, IsToldByAmplitudesAndTheirErrors) {
  Swing problem;
  problem.observe(swinging(0, 0), {.seed = 5, .stream = 1});
  const auto told = [&](double size, double sigma, double phase, double sigma_phase) {
    Assessment stated{.model = swinging(size, phase), .unknowns = {{"swing", 0}, {"swing", 1}}};
    stated.fit.value = {size, phase}, stated.fit.sigma = {sigma, sigma_phase};
    stated.fit.at_bound = {0, 0};
    return is_at_neutral(problem, stated, "swing");
  };
  EXPECT_TRUE(told(1e-4, 1e-3, 0.1, 0.5));
  EXPECT_TRUE(told(1e-4, 1e-3, 2, 0.1));
  EXPECT_FALSE(told(0.5, 0.1, 0.1, 0.5));
  EXPECT_FALSE(told(0.5, 0.1, 2, 0.5));
  EXPECT_TRUE(told(0.5, std::numeric_limits<double>::infinity(), 0.1, 0.5));
}

// Two values that stand for each other: each within its error, and clear of neutral as a pair.
TEST(IsAtNeutral, CountsValuesThatHangTogether) {
  Swing problem;
  problem.observe(swinging(0, 0), {.seed = 5, .stream = 1});
  const auto told = [&](double correlation) {
    Assessment stated{.model = swinging(0.1, 0.1), .unknowns = {{"swing", 0}, {"swing", 1}}};
    stated.fit.value = {0.1, 0.1}, stated.fit.sigma = {0.1, 0.1};
    stated.fit.covariance = {0.01, 0.01 * correlation, 0.01 * correlation, 0.01};
    return is_at_neutral(problem, stated, "swing");
  };
  EXPECT_TRUE(told(0));
  EXPECT_TRUE(told(0.9));
  EXPECT_FALSE(told(-0.99));
}

TEST(RemoveNeutral, LeavesWhatTheDataSupport) {
  for (const double truth : {0.0, 0.5}) {
    Swing problem;
    problem.observe(swinging(truth, 1), {.seed = 5, .stream = 1});
    const std::vector<Unknown> unknowns = {{"slope", 0}, {"swing", 0}};
    Grown grown{.added = {"swing"}, .assessment = assess(problem, swinging(0.01, 1), unknowns)};
    EXPECT_EQ(remove_neutral(problem, grown), truth == 0) << truth;
    EXPECT_EQ(grown.assessment.model.has("swing"), truth != 0) << truth;
    EXPECT_EQ(grown.added.empty(), truth == 0) << truth;
    EXPECT_NEAR(grown.assessment.model.find("slope")->value("size"), 3, 0.01);
  }
}

// Behind the effects found: what helps, then what does not, each by held-out likelihood.
TEST(RankBySearch, HasOneOrder) {
  Swing problem;
  problem.observe(swinging(0, 0), {.seed = 5, .stream = 1});
  SearchResult result;
  result.base.assessment = assess(problem, swinging(0, 0), {});
  result.steps = {{.effect = "d"}};
  const auto add = [&](const char* name, bool significant, double gain_ll) {
    Candidate candidate{.effect = effect_of(name), .grown = result.base, .gain_ll = gain_ll};
    candidate.significant = significant;
    result.first.candidates.push_back(candidate);
  };
  add("a", true, 10), add("b", false, 900), add("c", true, 600), add("d", true, 5);
  add("e", false, 950);
  rank_by_search(problem, result);
  std::string order;
  for (const Candidate& candidate : result.first.candidates) order += candidate.effect->name;
  EXPECT_EQ(order, "dcaeb");
}

TEST(AddOnce, KeepsNamesApart) {
  std::vector<std::string> names;
  for (const char* name : {"stribeck_friction", "cogging", "stribeck_friction"})
    add_once(names, name);
  EXPECT_EQ(names, (std::vector<std::string>{"stribeck_friction", "cogging"}));
}

}  // namespace
}  // namespace seam::measurement
