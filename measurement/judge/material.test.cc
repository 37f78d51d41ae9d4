// Significant is not material: what moves predictions by a twentieth of the noise is a trace,
// however sure; the sizes are computed in another way.
#include "measurement/judge/material.h"

#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "effects/registry.h"
#include "measurement/kinds/kinds.h"
#include "measurement/problem/made_problem.h"
#include "measurement/report/results.h"
#include "measurement/search/choice.h"
#include "measurement/search/search.h"
#include "measurement/study/study.h"
#include "sim_core/base/output.h"

namespace seam::measurement {
namespace {

constexpr double kSlopeNoise = 0.5;
constexpr size_t kRows = 40'000;

std::shared_ptr<const EffectDefinition> level() {
  return made_effect("line", {{.name = "level", .min = -100, .max = 100, .scale = 1}});
}
std::shared_ptr<const EffectDefinition> slope() {
  return made_effect("slope", {{.name = "size", .min = -100, .max = 100, .scale = 1}});
}

// y = level + size * x, in groups that see the whole range.
class Sloped : public MadeProblem {
 public:
  Sloped()
      : MadeProblem(evenly(-1, 1, kRows), kSlopeNoise, [](const std::vector<double>& p, double x) {
          return p[0] + (p.size() > 1 ? p[1] * x : 0);
        }) {
    deal_into(20);
    facts_.covariates = {{.name = "x", .values = x()}};
  }
  std::vector<std::vector<double>> starts(const Model&, const EffectDefinition&) const override {
    return {{0.05}};
  }
};

// A slope that moves predictions by `units` of the noise: x has the root mean square 1/sqrt(3).
Candidate slope_of(double units, double material) {
  Sloped problem;
  Model flat, truth;
  flat.set(level(), {{.value = 0, .free = true}});
  truth.set(level(), {{.value = 0.3}});
  truth.set(slope(), {{.value = units * kSlopeNoise * std::sqrt(3.0)}});
  problem.observe(truth, {.seed = 4, .stream = 1});
  problem.prepare(flat);
  const Grown base{.assessment = assess(problem, flat, refitted_unknowns(flat))};
  const SplitStructure split = significant_structure(problem, base.assessment, material);
  const bool small = units < material;
  EXPECT_EQ(split.material.empty(), small);
  EXPECT_FALSE((small ? split.traces : split.material).empty());
  for (const Structure& s : small ? split.traces : split.material)
    EXPECT_NEAR(noise_units(problem, base.assessment, s), units, 0.3 * units) << s.covariate;
  const Looks looks = look_at(problem, base, {slope()}, material);
  EXPECT_EQ(looks.candidates.size(), 1u);
  return looks.candidates.front();
}

TEST(Material, ATwentiethOfTheNoiseIsATrace) {
  const Candidate candidate = slope_of(0.05, 0.1);
  EXPECT_LT(candidate.p_value, 1e-9);
  EXPECT_NEAR(candidate.moved, 0.05, 0.01);
  EXPECT_TRUE(candidate.trace);
  EXPECT_FALSE(candidate.significant);
}

// Points that are each off by something of their own, seen four times: their means alone explain a
// quarter of noise by chance.
class Displaced : public MadeProblem {
 public:
  static constexpr size_t kPoints = 1000, kTimes = 4;
  Displaced()
      : MadeProblem(points(), kSlopeNoise, [](const std::vector<double>& p, double x) {
          return p[0] + (p.size() > 1 ? p[1] * std::sqrt(2.0) * std::sin(1.3 * x * x) : 0);
        }) {
    deal_into(20);
    facts_.covariates = {{.name = "point", .type = Covariate::Type::category, .values = points()}};
  }
  static std::vector<double> points() {
    std::vector<double> labels(kPoints * kTimes);
    for (size_t i = 0; i < labels.size(); ++i) labels[i] = static_cast<double>(i % kPoints);
    return labels;
  }
};

TEST(Material, WhatChanceExplainsOfGroupMeansIsNotHidden) {
  for (const double units : {0.4, 0.8}) {
    Displaced problem;
    Model flat, truth;
    flat.set(level(), {{.value = 0, .free = true}});
    truth.set(level(), {{.value = 0.3}});
    truth.set(slope(), {{.value = units * kSlopeNoise}});
    problem.observe(truth, {.seed = 4, .stream = 2});
    problem.prepare(flat);
    const Assessment assessment = assess(problem, flat, refitted_unknowns(flat));
    const auto left = problem.structure(assessment.model, problem.all_groups(), 1);
    ASSERT_FALSE(left.empty());
    EXPECT_EQ(left[0].covariate, "point");
    const double share = units * units / (1 + units * units);
    EXPECT_NEAR(left[0].explained, share, 0.04);
    EXPECT_EQ(hides_mean(problem, assessment, assessment), share > 0.25);
  }
}

TEST(Material, ZeroAsksForSignificanceAlone) {
  const Candidate candidate = slope_of(0.05, 0);
  EXPECT_TRUE(candidate.significant);
  EXPECT_FALSE(candidate.trace);
}

TEST(Material, ThreeTenthsOfTheNoiseMatter) {
  const Candidate candidate = slope_of(0.3, 0.1);
  EXPECT_NEAR(candidate.moved, 0.3, 0.02);
  EXPECT_TRUE(candidate.significant);
  EXPECT_FALSE(candidate.trace);
}

// Noise of 0.5 beside a spread of 0.375 is 0.625 in all: a quarter more.
TEST(Material, ASpreadMovesStandardDeviations) {
  Sloped problem;
  const auto spread =
      made_effect("wider", {{.name = "sigma", .min = 0, .max = 100, .scale = 1}}, true);
  Assessment before, after;
  before.model.set(level(), {{.value = 0}});
  after.model = before.model;
  after.model.set(spread, {{.value = 0.375}});
  const Evaluation here = problem.evaluate(before.model, problem.scored_groups());
  EXPECT_NEAR(change_by(problem, here, before, after, true).moved, 0.25, 1e-9);
}

// A recording of the study's room with 600 frames, by a camera whose rows are read one after the
// other. Its head swings with 2.9 rad/s root mean square, which is 467 px/s in the image's middle;
// rows 0 to 143 have the root mean square 83: a delay of one second a row moves u by about 3.9e4
// px, and by some more off the middle.
std::unique_ptr<Problem> long_recording(double units, const std::string& name, Model& nominal) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("material-" + name);
  std::filesystem::create_directories(folder / "protocol");
  nominal = write_study_protocol("points", folder / "protocol");
  std::string table = "frame,time_s,point,x_m,y_m,z_m\n";
  for (int frame = 0; frame < 600; ++frame) {
    for (int k = 0; k < 64; ++k) {
      const double bearing = -1.3 + 2.6 * k / 63, range = 0.7 + 2.3 * (k * 37 % 64) / 63.0;
      table += fmt::format("{},{:.6f},{},{:.5f},{:.5f},{:.5f}\n", frame, 0.15 + 0.006 * frame, k,
                           range * std::cos(bearing), range * std::sin(bearing),
                           0.25 + range * (-0.55 + 1.1 * (k * 23 % 64) / 63.0));
    }
  }
  write_file_atomically(folder / "protocol/points.csv", table);
  Model truth = nominal;
  truth.add_neutral(effects::find_effect("rolling_shutter"));
  truth.set_value("rolling_shutter", 0, units * 0.15 / 3.9e4);
  measure_set(truth, MeasurementSet::open(folder / "protocol"), {.seed = 5, .out = folder / "set"});
  return open_problem(folder / "set");
}

TEST(Material, ATraceLeavesTheModelAdequateUnlessItIsAskedFor) {
  Model nominal;
  const auto problem = long_recording(0.05, "trace", nominal);
  const SearchResult usual = search(*problem, nominal, {}, [](const std::string&) {});
  EXPECT_EQ(usual.verdict, "adequate");
  EXPECT_TRUE(usual.steps.empty());
  const std::vector<Candidate> traces = traces_of(usual.first.candidates);
  ASSERT_FALSE(traces.empty());
  const auto shutter = std::find_if(traces.begin(), traces.end(), [](const Candidate& c) {
    return c.effect->name == "rolling_shutter";
  });
  ASSERT_NE(shutter, traces.end());
  EXPECT_NEAR(shutter->moved, 0.05, 0.015);
  const std::string text = diagnose_text(*problem, usual);
  EXPECT_EQ(text.find("Nothing that matters: differences stay below 0.1 of the noise ("), 0u)
      << text;
  EXPECT_NE(text.find("\ntraces, significant but not material: "), std::string::npos) << text;
  const SearchResult asked = search(
      *problem, nominal, {}, [](const std::string&) {}, /*material=*/0);
  EXPECT_EQ(asked.verdict, "missing_effect");
  ASSERT_EQ(asked.steps.size(), 1u);
  // At this size the data cannot tell it from others that move things while the head turns.
  std::vector<std::string> named = asked.steps[0].indistinguishable_from;
  named.push_back(asked.steps[0].effect);
  EXPECT_NE(std::find(named.begin(), named.end(), "rolling_shutter"), named.end())
      << fmt::format("{}", fmt::join(named, ", "));
}

TEST(Material, AnEffectOfThreeTenthsIsFound) {
  Model nominal;
  const auto problem = long_recording(0.3, "found", nominal);
  const SearchResult result = search(*problem, nominal, {}, [](const std::string&) {});
  EXPECT_EQ(result.verdict, "missing_effect");
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, "rolling_shutter");
  EXPECT_NEAR(result.steps[0].moved, 0.3, 0.1);
  EXPECT_EQ(discover_text(*problem, result)
                .find("What matters: rolling_shutter is missing; it moves predictions by 0."),
            0u);
}

}  // namespace
}  // namespace seam::measurement
