// Fits without a part, against fits that were made without it.
#include "measurement/fitting/leave_out.h"

#include <gtest/gtest.h>

#include <cmath>

#include "measurement/problem/made_problem.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

constexpr double kNoise = 0.5;
constexpr size_t kRows = 120;

// y = level + slope * x, in so many groups of neighbours, or one.
class Line : public MadeProblem {
 public:
  explicit Line(
      size_t groups, const Formula& formula = [](const std::vector<double>& p,
                                                 double x) { return p[0] + p[1] * x; })
      : MadeProblem(evenly(-1, 1, kRows), kNoise, formula) {
    cut_into(groups);
  }
};

std::shared_ptr<const EffectDefinition> line(const std::string& second) {
  return made_effect("line", {{.name = "level", .min = -100, .max = 100, .scale = 1},
                              {.name = second, .min = -100, .max = 100, .scale = 1}});
}

// The likelihood of rows under the least-squares line through others: normal equations by hand.
double by_hand(const MadeProblem& problem, const std::vector<char>& unseen,
               const std::vector<char>& scored) {
  double n = 0, x = 0, xx = 0, y = 0, xy = 0;
  for (size_t i = 0; i < kRows; ++i) {
    if (unseen[i]) continue;
    const double u = problem.x()[i], v = problem.y()[i];
    ++n, x += u, xx += u * u, y += v, xy += u * v;
  }
  const double slope = (n * xy - x * y) / (n * xx - x * x), level = (y - slope * x) / n;
  double sum = 0;
  for (size_t i = 0; i < kRows; ++i) {
    if (!scored[i]) continue;
    const double z = (problem.y()[i] - level - slope * problem.x()[i]) / kNoise;
    sum -= 0.5 * (z * z + std::log(2 * maths::kPi)) + std::log(kNoise);
  }
  return sum;
}

struct Held {
  std::vector<HeldPart> parts;
  std::vector<Score> scores;
};

Held held(Line& problem, const std::string& second) {
  const Model truth = made_model(line(second), {0.3, 0.2});
  problem.observe(truth, {.seed = 3, .stream = 1});
  const std::vector<Unknown> unknowns = {{"line", 0}, {"line", 1}};
  const Fit fit = problem.fit(truth, unknowns, problem.all_groups());
  return {held_parts(problem, fit.model), scores_held_out(problem, fit, unknowns)};
}

TEST(LeaveOut, AGroupIsScoredAsAFitToTheOthersSays) {
  for (const size_t groups : {2, 4, 6}) {
    Line problem(groups);
    const Held out = held(problem, "slope");
    ASSERT_EQ(out.scores.size(), groups);
    for (size_t p = 0; p < groups; ++p) {
      const double exact = by_hand(problem, out.parts[p].unseen, out.parts[p].unseen);
      EXPECT_NEAR(out.scores[p].log_likelihood, exact, 1e-4 * std::abs(exact)) << groups;
    }
  }
}

TEST(LeaveOut, OneGroupIsHeldOutByBlocks) {
  Line problem(1);
  const Held out = held(problem, "slope");
  ASSERT_EQ(out.scores.size(), 8u);
  int64_t rows = 0;
  for (size_t p = 0; p < out.scores.size(); ++p) {
    std::vector<char> scored(kRows);
    for (size_t i = 0; i < kRows; ++i) scored[i] = problem.blocks()[i] == static_cast<int>(p);
    EXPECT_EQ(out.parts[p].unseen, scored);  // Nothing is remembered, so that there is no gap.
    const double exact = by_hand(problem, scored, scored);
    EXPECT_NEAR(out.scores[p].log_likelihood, exact, 1e-4 * std::abs(exact));
    rows += out.scores[p].n;
  }
  EXPECT_EQ(rows, static_cast<int64_t>(kRows));
}

// Rows are a second apart, blocks of fifteen: a memory of 3 s takes so many rows on each side.
TEST(LeaveOut, TheGapIsTheModelsMemory) {
  Line problem(1);
  EXPECT_EQ(memory_s(made_model(line("lag_s"), {5, -3})), 3);
  const auto parts = held_parts(problem, made_model(line("lag_s"), {0, 3}));
  ASSERT_EQ(parts.size(), 8u);
  for (size_t i = 0; i < kRows; ++i)
    EXPECT_EQ(parts[2].unseen[i], i > 27 && i < 47) << i;  // The block is 30 to 44.
}

// y = a b, and in the last group more of a: without it a product tells next to nothing of its
// factors, and a straight step along it leaves the product's curve.
TEST(LeaveOut, AGroupThatAloneTellsAValueIsNoLongStepAway) {
  double lost = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Line problem(4, [](const std::vector<double>& p, double x) {
      return p[0] * p[1] + (x < 0.5 ? 0.05 : 0.3) * x * p[0];
    });
    const Model truth = made_model(line("slope"), {4, 3});
    problem.observe(truth, {.seed = seed, .stream = 1});
    const std::vector<Unknown> unknowns = {{"line", 0}, {"line", 1}};
    const Fit fit = problem.fit(truth, unknowns, problem.all_groups());
    const auto scores = scores_held_out(problem, fit, unknowns);
    const Fit rest = problem.fit(fit.model, unknowns, {1, 1, 1, 0});
    const double exact = problem.score(rest.model, {0, 0, 0, 1}).log_likelihood;
    lost += (exact - scores[3].log_likelihood) / 20;
  }
  EXPECT_LT(lost, 5);
}

// The noise of one group is wider: a fit of the noise without it is that of the others.
TEST(LeaveOut, ANoiseIsFittedWithoutTheGroup) {
  Line problem(4);
  const auto wider =
      made_effect("wider", {{.name = "sigma", .min = 0, .max = 100, .scale = 1}}, true);
  Model truth = made_model(line("slope"), {0.3, 0.2});
  truth.set(wider, {{.value = 1}});
  problem.observe(truth, {.seed = 4, .stream = 1});
  const std::vector<Unknown> unknowns = {{"wider", 0}};
  const Fit fit = problem.fit(truth, unknowns, problem.all_groups());
  const auto scores = scores_held_out(problem, fit, unknowns);
  ASSERT_EQ(scores.size(), 4u);
  for (size_t g = 0; g < 4; ++g) {
    Groups fold(4, 0);
    fold[g] = 1;
    const Fit refit = problem.fit(truth, unknowns, complement(fold));
    EXPECT_NEAR(scores[g].log_likelihood, problem.score(refit.model, fold).log_likelihood, 0.05);
  }
}

}  // namespace
}  // namespace seam::measurement
