// Causes without a name against the steps of a search.
#include "measurement/search/without_name.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "measurement/kinds/kinds.h"
#include "measurement/problem/made_problem.h"
#include "measurement/study/study.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using testing::Contains;
using testing::ContainsRegex;
using testing::HasSubstr;

constexpr double kNoiseOfWave = 0.1;

std::shared_ptr<const EffectDefinition> sized(const std::string& name) {
  return made_effect(name, {{.name = "size", .min = -100, .max = 100, .scale = 1}});
}

// y = level + size shape(x), of data that are a wave.
struct Wave : MadeProblem {
  explicit Wave(double (*shape)(double))
      : MadeProblem(evenly(-1, 1, 600), kNoiseOfWave,
                    [shape](const std::vector<double>& p, double x) {
                      return p[0] + (p.size() > 1 ? p[1] * shape(x) : 0);
                    }) {
    deal_into(12);
    facts_.covariates = {{.name = "x", .values = x()}};
    std::vector<double> y;
    for (size_t i = 0; i < x().size(); ++i)
      y.push_back(0.2 * wave(x()[i]) + kNoiseOfWave * normal({7, 2}, i));
    take(std::move(y));
  }
  static double wave(double x) { return std::sin(5 * x); }
  static double cube(double x) { return x * x * x; }
};

TEST(LookForUnnamed, AStepThatOnlyImitatesAWaveIsNoStep) {
  const Wave problem(Wave::cube);
  Model level, cube;
  level.set(sized("level"), {{.value = 0}});
  cube = level;
  cube.set(sized("cube"), {{.value = 0}});
  SearchResult result{.material = kMaterial};
  result.base = {.assessment = assess(problem, level, {{"level", 0}})};
  result.best = {.added = {"cube"},
                 .assessment = assess(problem, cube, {{"level", 0}, {"cube", 0}})};
  ASSERT_LT(result.best.assessment.error, result.base.assessment.error);
  result.steps = {{.effect = "cube", .after = result.best.assessment}};
  look_for_unnamed(problem, KnownCauses{1}, result);
  ASSERT_TRUE(result.unnamed);
  EXPECT_EQ(result.unnamed->depends_on, std::vector<std::vector<std::string>>{{"x"}});
  EXPECT_EQ(result.mimics, std::vector<std::string>{"cube"});
  EXPECT_TRUE(result.steps.empty());
  EXPECT_FALSE(result.best.assessment.model.has("cube"));
}

// A function that is ahead by less than it must be of a mean takes the place of a spread.
TEST(LookForUnnamed, OfASpreadAFunctionNeedsNoLead) {
  const Wave problem(Wave::wave);
  Model level;
  level.set(sized("level"), {{.value = 0}});
  const Grown base{.assessment = assess(problem, level, {{"level", 0}})};
  // Over one that explains the wave, or drowns it, whose log-evidence is ahead by so much.
  const auto lead_of = [&](bool is_spread, double ahead) {
    Grown last = base;
    last.added = {"other"};
    last.assessment.model.set(
        made_effect("other", {{.name = "size", .min = 0, .max = 9}}, is_spread),
        {{.value = is_spread ? 5 : 0.2}});
    last.assessment.total_ll += ahead;
    last.assessment.error = 1;
    const auto cause = unnamed_beside(problem, {base, last}, kMaterial, KnownCauses{1});
    return cause ? cause->lead : 0;
  };
  const double far = lead_of(false, 0);
  ASSERT_GT(far, kUnnamedWidth);
  EXPECT_EQ(lead_of(false, far - 0.5 * kUnnamedWidth), 0);
  const double of_spread = lead_of(true, 0);
  EXPECT_GT(lead_of(true, of_spread - 0.5 * kUnnamedWidth), 0);
  EXPECT_EQ(lead_of(true, of_spread + 1), 0);
}

// y = level + cube x^3 + fast cos(60 x), of data that have a wave beside these: smooth functions do
// what the cube does, and not the fast part. Each effect has its size and its shape.
class CubeAndFast : public testing::Test {
 protected:
  static constexpr double kLevel = 0, kCube = 3, kFast = 60;

  struct Waves : MadeProblem {
    Waves() : MadeProblem(evenly(-1, 1, 600), kNoiseOfWave, sum_of) {
      deal_into(12);
      facts_.covariates = {{.name = "x", .values = x()}};
      std::vector<double> y;
      for (size_t i = 0; i < x().size(); ++i)
        y.push_back(0.2 * std::sin(5 * x()[i]) +
                    sum_of({1, kLevel, 0.5, kCube, 0.3, kFast}, x()[i]) +
                    kNoiseOfWave * normal({7, 2}, i));
      take(std::move(y));
    }
    static double sum_of(const std::vector<double>& p, double at) {
      double sum = 0;
      for (size_t k = 0; k + 1 < p.size(); k += 2)
        sum += p[k] * (p[k + 1] == kFast ? std::cos(60 * at) : std::pow(at, p[k + 1]));
      return sum;
    }
  };

  CubeAndFast() {
    Model model;
    std::vector<Unknown> unknowns;
    const std::vector<std::pair<std::string, double>> shapes = {
        {"level", kLevel}, {"cube", kCube}, {"fast", kFast}};
    for (const auto& [name, shape] : shapes) {
      model.set(made_effect(name, {{.name = "size", .min = -100, .max = 100, .scale = 1},
                                   {.name = "shape", .min = 0, .max = 100}}),
                {{.value = 0}, {.value = shape}});
      unknowns.push_back({name, 0});
      const Assessment after = assess(problem_, model, unknowns);
      if (unknowns.size() == 1) result_.base = result_.best = {.assessment = after};
      if (unknowns.size() == 1) continue;
      result_.best.added.push_back(name);
      result_.best.assessment = after;
      result_.steps.push_back({.effect = name, .after = after});
    }
  }

  const Waves problem_;
  SearchResult result_{.material = kMaterial};
};

TEST_F(CubeAndFast, AStepGoesThatFunctionsCanDoAndOneStaysThatTheyCannot) {
  const Assessment best = result_.best.assessment;
  EXPECT_LT(own_shares(problem_, best, {{"cube"}})[0], 0.1);
  EXPECT_GT(own_shares(problem_, best, {{"fast"}})[0], 0.9);
  look_for_unnamed(problem_, KnownCauses{1}, result_);
  ASSERT_TRUE(result_.unnamed);
  EXPECT_EQ(result_.mimics, std::vector<std::string>{"cube"});
  ASSERT_EQ(result_.steps.size(), 1u);
  EXPECT_EQ(result_.steps[0].effect, "fast");
  EXPECT_FALSE(result_.best.assessment.model.has("cube"));
  EXPECT_EQ(result_.steps[0].error_after, result_.best.assessment.error);
}

// Of data that are a wave, a cube and a fifth power beside the level are no nearer to it than
// smooth functions beside the level alone.
TEST(NamesImitate, StepsThatFunctionsDoBetterEndASearch) {
  struct Wave : MadeProblem {
    Wave() : MadeProblem(evenly(-1, 1, 600), kNoiseOfWave, powers) {
      deal_into(12);
      facts_.covariates = {{.name = "x", .values = x()}};
      std::vector<double> y;
      for (size_t i = 0; i < x().size(); ++i)
        y.push_back(0.4 * std::sin(14 * x()[i]) + kNoiseOfWave * normal({7, 2}, i));
      take(std::move(y));
    }
    static double powers(const std::vector<double>& p, double at) {
      double sum = 0;
      for (size_t k = 0; k < p.size(); ++k)
        sum += p[k] * std::pow(at, k == 0 ? 0 : 2 * static_cast<double>(k) + 1);
      return sum;
    }
  };
  const Wave problem;
  Model model;
  std::vector<Unknown> unknowns;
  std::vector<Grown> way;
  for (const std::string name : {"level", "cube", "fifth"}) {
    model.set(sized(name), {{.value = 0}});
    unknowns.push_back({name, 0});
    way.push_back({.assessment = assess(problem, model, unknowns)});
    if (way.size() > 1) way.back().added = way[way.size() - 2].added;
    if (way.size() > 1) way.back().added.push_back(name);
    // The first step may stand for several effects.
    EXPECT_EQ(names_imitate(problem, way, kMaterial, KnownCauses{1}), way.size() == 3) << name;
  }
  // What begins with noise is no explanation yet.
  EffectDefinition noise = *sized("cube");
  noise.spread_only = true;
  way[1].assessment.model.set(std::make_shared<const EffectDefinition>(noise), {{.value = 1}});
  EXPECT_FALSE(names_imitate(problem, way, kMaterial, KnownCauses{1}));
}

TEST_F(CubeAndFast, AStepThatFunctionsCannotDoEndsNone) {
  std::vector<Grown> way = {result_.base};
  for (const Step& step : result_.steps) {
    way.push_back({.added = way.back().added, .assessment = step.after});
    way.back().added.push_back(step.effect);
  }
  EXPECT_FALSE(names_imitate(problem_, way, kMaterial, KnownCauses{1}));
}

TEST_F(CubeAndFast, WhatIsDoubtedGoesWhereFunctionsCanDoIt) {
  result_.steps[1].doubts = {"its range ends"};
  EXPECT_FALSE(leave_out_doubted(problem_, KnownCauses{1}, result_));
  result_.steps[1].doubts.clear(), result_.steps[0].doubts = {"its range ends"};
  EXPECT_TRUE(leave_out_doubted(problem_, KnownCauses{1}, result_));
  EXPECT_EQ(result_.mimics, std::vector<std::string>{"cube"});
  ASSERT_TRUE(result_.unnamed);
  EXPECT_EQ(result_.unnamed->beside, 1u);
}

// What a search finds in a set of this kind with an effect that no catalogue has.
SearchResult found_in(const std::string& kind, const std::string& name, const std::string& effect) {
  const std::filesystem::path protocol = std::filesystem::path(testing::TempDir()) / name,
                              out = protocol.string() + "-set";
  const Model nominal = write_study_protocol(kind, protocol);
  if (kind == "landmarks") write_landmark_walks(protocol, 60, 0);
  const ConfigNode node = ConfigNode::from_text(effect, "truth");
  const auto definition = effects::expression_effect("truth", node);
  Model truth = nominal;
  truth.set(definition, effects::expression_values(*definition, node));
  std::filesystem::remove_all(out);
  measure_set(truth, MeasurementSet::open(protocol), {.seed = 3, .out = out});
  const auto problem = open_problem(out);
  return search(*problem, nominal, {}, [](const std::string&) {});
}

// Its half periods are more than smooth functions have.
TEST(LookForFormula, AFastWaveIsAFormula) {
  const SearchResult result = found_in(
      "joints", "formula-fast", "{stage: joint, q: 'q + k * sin(37 * t)', parameters: {k: 0.004}}");
  ASSERT_TRUE(result.suggestion);
  EXPECT_THAT(result.suggestion->formula, HasSubstr("sin(2 * pi * t / 0.169"));
  EXPECT_NEAR(result.suggestion->error, 1, 0.1);
  EXPECT_EQ(result.verdict, "unexplained_structure");
  EXPECT_TRUE(result.steps.empty());
}

// Ranges to what is near are too short, less and less with the distance.
TEST(LookForFormula, ADecayHasItsLength) {
  const SearchResult result =
      found_in("landmarks", "formula-near",
               "{stage: detector, range: 'range - k * exp(-range / s)', bearing: bearing, "
               "parameters: {k: 0.3, s: {value: 0.7, neutral: 0.7, min: 0.1, max: 10}}}");
  ASSERT_TRUE(result.suggestion);
  EXPECT_THAT(result.suggestion->formula, ContainsRegex("exp[(]-range / 0.(6[5-9]|7)"));
  EXPECT_NEAR(result.suggestion->error, 1, 0.1);
  EXPECT_EQ(result.verdict, "unexplained_structure");
}

// An error that wanders takes a slow wave as well as it takes anything: it comes after the formula.
TEST(LookForFormula, AWaveIsNoWander) {
  const SearchResult result =
      found_in("landmarks", "formula-slow",
               "{stage: detector, range: 'range + k * sin(t)', bearing: bearing, "
               "parameters: {k: 0.03}}");
  ASSERT_TRUE(result.suggestion);
  EXPECT_THAT(result.suggestion->formula, HasSubstr("range: 0.0"));
  EXPECT_THAT(result.suggestion->formula, HasSubstr("sin(2 * pi * t / 6.2"));
  EXPECT_THAT(result.mimics, Contains("range_wander"));
  EXPECT_EQ(result.verdict, "unexplained_structure");
  EXPECT_TRUE(result.steps.empty());
}

}  // namespace
}  // namespace seam::measurement
