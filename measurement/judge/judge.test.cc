// When an effect counts as found, against calculations of other ways: likelihood ratios from sums
// of squares, tails in closed form, and ties told by hand.
#include "measurement/judge/judge.h"

#include <gtest/gtest.h>

#include <cmath>

#include "effects/registry.h"
#include "measurement/judge/decisions.h"
#include "measurement/problem/made_problem.h"
#include "measurement/search/candidates.h"
#include "measurement/search/choice.h"

namespace seam::measurement {
namespace {

constexpr double kNoise = 0.5;

std::shared_ptr<const EffectDefinition> line() {
  return made_effect("line", {{.name = "level", .min = -100, .max = 100, .scale = 1}});
}
std::shared_ptr<const EffectDefinition> bend() {
  return made_effect("bend", {{.name = "size", .min = -100, .max = 100, .scale = 1}});
}

// y = level + size * x^2, in groups of eight.
class Bent : public MadeProblem {
 public:
  Bent()
      : MadeProblem(evenly(-1, 1, 160), kNoise, [](const std::vector<double>& p, double x) {
          return p[0] + (p.size() > 1 ? p[1] * x * x : 0);
        }) {
    deal_into(20);
  }
  std::vector<std::vector<double>> starts(const Model&, const EffectDefinition&) const override {
    return {{0.05}};
  }
};

Model flat() {
  Model model;
  model.set(line(), {{.value = 0, .free = true}});
  return model;
}

struct Judged {
  Bent problem;
  Grown base;
  Candidate candidate;
};

std::unique_ptr<Judged> judged(double size, uint64_t seed, double looks) {
  auto all = std::make_unique<Judged>();
  Model truth;
  truth.set(line(), {{.value = 0.3}});
  truth.set(bend(), {{.value = size}});
  all->problem.observe(truth, {.seed = seed, .stream = 1});
  all->problem.prepare(flat());
  all->base = {.assessment = assess(all->problem, flat(), refitted_unknowns(flat()))};
  std::vector<NotTestable> reasons;
  auto candidate = try_effect(all->problem, all->base, bend(), reasons);
  EXPECT_TRUE(candidate);
  all->candidate = std::move(*candidate);
  const Evaluation here =
      all->problem.evaluate(all->base.assessment.model, all->problem.scored_groups());
  judge(all->problem, all->base, here, looks, 0, all->candidate);
  return all;
}

// Sums of squares of the least-squares line and parabola over training groups, then what both leave
// on all groups: by hand, with normal equations.
double gain_by_hand(const Bent& problem) {
  const Groups training = problem.training_groups();
  double n = 0, s2 = 0, s4 = 0, y0 = 0, y2 = 0;
  for (size_t i = 0; i < problem.x().size(); ++i) {
    if (!training[problem.facts().group_of(i)]) continue;
    const double q = problem.x()[i] * problem.x()[i], y = problem.y()[i];
    ++n, s2 += q, s4 += q * q, y0 += y, y2 += y * q;
  }
  const double mean = y0 / n;
  const double size = (n * y2 - s2 * y0) / (n * s4 - s2 * s2), level = (y0 - size * s2) / n;
  double gain = 0;
  for (size_t i = 0; i < problem.x().size(); ++i) {
    const double q = problem.x()[i] * problem.x()[i], y = problem.y()[i];
    gain += std::pow(y - mean, 2) - std::pow(y - level - size * q, 2);
  }
  return gain / (2 * kNoise * kNoise);
}

TEST(Judge, GainAndPAreThoseOfSumsOfSquares) {
  for (const double size : {0.4, 0.8, 1.6}) {
    const auto all = judged(size, 5, 7);
    const double gain = gain_by_hand(all->problem);
    EXPECT_NEAR(all->candidate.total_gain_ll, gain, 2e-3 * (1 + gain)) << size;
    // A chi-square of one degree of freedom is a squared normal: its tail is erfc.
    const double error = all->candidate.grown.assessment.error;
    const double ratio = 2 * all->candidate.total_gain_ll / std::max(1.0, error * error);
    const double p = std::min(1.0, 7 * std::erfc(std::sqrt(0.5 * ratio)));
    EXPECT_NEAR(all->candidate.p_value / p, 1, 1e-9) << size;
  }
}

TEST(Judge, FoundWhereItIsAndNotWhereItIsNot) {
  // One standard error of the size is about 0.2: eight of them are always found.
  int found = 0, alarms = 0;
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    found += judged(1.6, seed, 1)->candidate.significant;
    alarms += judged(0, seed, 1)->candidate.significant;
  }
  EXPECT_EQ(found, 100);
  EXPECT_LE(alarms, 2);  // Of 100 with a design of 0.5 %: three or more in one of 700 trials.
}

// What a draw of each point can stand for is anything, so that something must be explained before.
TEST(Judge, DrawsAreTriedWhereSomethingIsExplained) {
  const auto all = judged(0, 1, 1);
  EffectDefinition draws = *bend();
  draws.draws_estimated = true;
  const auto tried = [&](double error) {
    Grown base = all->base;
    base.assessment.error = error;
    std::vector<NotTestable> reasons;
    prospect_of(all->problem, base, std::make_shared<const EffectDefinition>(draws), reasons);
    return reasons.empty();
  };
  EXPECT_TRUE(tried(5));
  EXPECT_FALSE(tried(13));
}

// Beside one of the right camera's own, an effect of all cameras is the left one's.
TEST(Judge, AnEffectOfOneCameraHasItsName) {
  Bent problem;
  problem.take(std::vector<double>(160, 0.0));
  Model given;
  for (const char* name : {"pinhole@left", "pinhole@right"})
    given.add_neutral(effects::find_effect(name));
  problem.prepare(given);
  Grown grown{.added = {"radial_distortion"}, .assessment = {.model = given}};
  const auto add = [&](const std::string& name, double value) {
    grown.assessment.model.set(effects::find_effect(name), {{.value = value}});
  };
  add("radial_distortion", -0.2);
  EXPECT_EQ(named_by_camera(problem, grown).added[0], "radial_distortion");
  add("radial_distortion@right", -0.1);
  grown.added.push_back("radial_distortion@right");
  const Grown named = named_by_camera(problem, grown);
  EXPECT_EQ(named.added, (std::vector<std::string>{"radial_distortion@left", grown.added[1]}));
  EXPECT_FALSE(named.assessment.model.has("radial_distortion"));
  EXPECT_EQ(named.assessment.model.find("radial_distortion@left")->parameters[0].value, -0.2);
  EXPECT_TRUE(named.assessment.valid);
}

TEST(Judge, GainOverScatterIsStudentsStatistic) {
  Score before, after;
  before.by_group = {-10, -12, 0, -9, -11};
  after.by_group = {-8, -11, 0, -6, -9};  // Gains 2, 1, 3, 2: mean 2, deviation sqrt(2 / 3).
  EXPECT_NEAR(gain_over_scatter(before, after), 2 / (std::sqrt(2.0 / 3) / 2), 1e-12);
  before.by_group = {-10, -12}, after.by_group = {-8, -11};
  EXPECT_EQ(gain_over_scatter(before, after), 0);
  // Their blocks: gains 1, 1, 0, 1 have the mean 0.75 and the deviation 0.5.
  before.by_block = {-5, -5, -6, -6}, after.by_block = {-4, -4, -6, -5};
  EXPECT_NEAR(gain_over_scatter(before, after), 3, 1e-12);
  before.by_group = {-10, -12, -9}, after.by_group = {-8, -11, -6};
  EXPECT_NEAR(gain_over_scatter(before, after), 2 / (1 / std::sqrt(3.0)), 1e-12);
  EXPECT_NEAR(gain_over_scatter(before, after, 4), 3, 1e-12);
}

// A bend beside a wave that nothing explains, in few groups of neighbours: the error stays above
// the noise.
class FewGroups : public MadeProblem {
 public:
  explicit FewGroups(size_t groups)
      : MadeProblem(evenly(-1, 1, 240), kNoise, [](const std::vector<double>& p, double x) {
          return p[0] + (p.size() > 1 ? p[1] * x * x : 0);
        }) {
    cut_into(groups);
  }
  std::vector<std::vector<double>> starts(const Model&, const EffectDefinition&) const override {
    return {{0.05}};
  }
};

Candidate beside_a_wave(size_t groups, double size, uint64_t seed) {
  FewGroups problem(groups);
  Model truth;
  truth.set(line(), {{.value = 0.3}});
  truth.set(bend(), {{.value = size}});
  problem.observe(truth, {.seed = seed, .stream = 1});
  std::vector<double> y = problem.y();
  for (size_t i = 0; i < y.size(); ++i) y[i] += 2 * kNoise * std::sin(40 * problem.x()[i]);
  problem.take(y);
  const Grown base{.assessment = assess(problem, flat(), refitted_unknowns(flat()))};
  std::vector<NotTestable> reasons;
  Candidate candidate = *try_effect(problem, base, bend(), reasons);
  const Evaluation here = problem.evaluate(base.assessment.model, problem.scored_groups());
  judge(problem, base, here, 20, 0.1, candidate);
  EXPECT_GT(candidate.grown.assessment.error, kMisfit);
  return candidate;
}

TEST(Judge, FewGroupsAddWhatIsPlain) {
  for (const size_t groups : {1, 2, 4, 6}) {
    const Candidate candidate = beside_a_wave(groups, 10, 1);
    EXPECT_TRUE(candidate.significant) << groups;
    EXPECT_TRUE(goes_before_spreads(candidate)) << groups;
    int alarms = 0;
    for (uint64_t seed = 1; seed <= 50; ++seed)
      alarms += beside_a_wave(groups, 0, seed).significant;
    EXPECT_LE(alarms, 2) << groups;
  }
}

// A noise that may be as wide as the misfit leaves errors of size 1; one that may not is no
// explanation.
TEST(Judge, ASpreadEndsAtTheNoiseOrIsNone) {
  for (const double widest : {100.0, 1.0}) {
    FewGroups problem(12);
    Model truth;
    truth.set(line(), {{.value = 0.3}});
    truth.set(bend(), {{.value = 10}});
    problem.observe(truth, {.seed = 2, .stream = 1});
    const auto wider =
        made_effect("wider", {{.name = "sigma", .min = 0, .max = widest, .scale = 0.5}}, true);
    const Grown base{.assessment = assess(problem, flat(), refitted_unknowns(flat()))};
    std::vector<NotTestable> reasons;
    Candidate candidate = *try_effect(problem, base, wider, reasons);
    const Evaluation here = problem.evaluate(base.assessment.model, problem.scored_groups());
    judge(problem, base, here, 20, 0.1, candidate);
    EXPECT_LT(candidate.p_value, 1e-6);
    EXPECT_EQ(candidate.significant, widest > 1) << candidate.grown.assessment.error;
    EXPECT_NEAR(candidate.fall, 0, 1e-3);
  }
}

TEST(CannotTell, WithinATie) {
  EXPECT_TRUE(cannot_tell(100, 104.5, 1));
  EXPECT_FALSE(cannot_tell(100, 104.7, 1));
  EXPECT_FALSE(cannot_tell(104.7, 100, 1));
  // Misfits count for less in proportion.
  EXPECT_TRUE(cannot_tell(100, 118, 2));
}

Candidate candidate(const std::string& name, size_t parameters, double gain, double merit,
                    double error = 1) {
  std::vector<effects::Parameter> definitions(parameters, {.name = "p", .min = -1, .max = 1});
  Candidate c{.effect = made_effect(name, definitions),
              .total_gain_ll = gain,
              .merit = merit,
              .significant = true};
  for (size_t i = 0; i < parameters; ++i) c.free.push_back(i);
  c.grown.assessment.error = error;
  return c;
}

std::vector<std::string> order(const std::vector<Candidate>& candidates) {
  std::vector<std::string> names;
  for (const Candidate& c : candidates) names.push_back(c.effect->name);
  return names;
}

TEST(Rank, TheLikeliestByEvidenceIsFirstAndTiesAreNamed) {
  std::vector<Candidate> candidates = {
      candidate("other", 1, 900, 896), candidate("fisheye", 4, 1007, 990),
      candidate("polynomial", 3, 1004, 992), candidate("radial", 1, 1000, 996.5)};
  rank_candidates(candidates);
  EXPECT_EQ(order(candidates),
            (std::vector<std::string>{"radial", "polynomial", "fisheye", "other"}));
  EXPECT_EQ(candidates[0].indistinguishable_from, (std::vector<std::string>{"polynomial"}));
  EXPECT_EQ(candidates[1].indistinguishable_from, (std::vector<std::string>{"radial", "fisheye"}));
  EXPECT_TRUE(candidates[3].indistinguishable_from.empty());
}

TEST(Rank, WhatTheDataTellApartIsNoTie) {
  std::vector<Candidate> candidates = {candidate("simple", 1, 1000, 996.5),
                                       candidate("right", 4, 1030, 1016)};
  rank_candidates(candidates);
  EXPECT_EQ(order(candidates), (std::vector<std::string>{"right", "simple"}));
  EXPECT_TRUE(candidates[0].indistinguishable_from.empty());
}

}  // namespace
}  // namespace seam::measurement
