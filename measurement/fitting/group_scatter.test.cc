// Errors by the scatter of groups, against fits that were made without each of them, and against
// truth over many draws.
#include "measurement/fitting/group_scatter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "measurement/problem/made_problem.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr double kRunNoise = 0.1, kAdequate = 1.15;
constexpr size_t kGroups = 5, kRowsAGroup = 30, kAllRows = kGroups * kRowsAGroup;

// y = level + slope * x, in groups that each see all x.
class Runs : public MadeProblem {
 public:
  Runs()
      : MadeProblem(abscissas(), kRunNoise,
                    [](const std::vector<double>& p, double x) { return p[0] + p[1] * x; }) {
    cut_into(kGroups);
  }
  // Lines through the origin whose level and slope differ from group to group.
  void draw(double level, double slope, RandomStream stream) {
    std::vector<double> y;
    for (size_t i = 0; i < kAllRows; ++i) {
      const RandomStream own = stream.child("group").child(i / kRowsAGroup);
      y.push_back(level * normal(own, 0) + slope * normal(own, 1) * x()[i] +
                  kRunNoise * normal(stream, i));
    }
    take(std::move(y));
  }

 private:
  static std::vector<double> abscissas() {
    std::vector<double> x;
    for (size_t i = 0; i < kAllRows; ++i)
      x.push_back(-1 + 2 * static_cast<double>(i % kRowsAGroup) / (kRowsAGroup - 1.0));
    return x;
  }
};

Model line_of(double level, double slope) {
  return made_model(made_effect("line", {{.name = "level", .min = -100, .max = 100, .scale = 1},
                                         {.name = "slope", .min = -100, .max = 100, .scale = 1}}),
                    {level, slope});
}

const std::vector<Unknown> kLevelAndSlope = {{"line", 0}, {"line", 1}};

// A fit to all groups, of which few are held out in turn; its errors are then widened.
Assessment widened(const Runs& problem, double& widest) {
  Assessment found = assess(problem, line_of(0, 0), kLevelAndSlope);
  widest = widen_by_group_scatter(problem, kAdequate, found);
  return found;
}

// Level and slope of the least-squares line through all groups but one: normal equations by hand.
std::pair<double, double> line_without(const Runs& problem, size_t group) {
  double n = 0, x = 0, xx = 0, y = 0, xy = 0;
  for (size_t i = 0; i < kAllRows; ++i) {
    if (i / kRowsAGroup == group) continue;
    const double u = problem.x()[i], v = problem.y()[i];
    ++n, x += u, xx += u * u, y += v, xy += u * v;
  }
  const double slope = (n * xy - x * y) / (n * xx - x * x);
  return {(y - slope * x) / n, slope};
}

TEST(GroupScatter, IsThatOfFitsWithoutEachGroup) {
  Runs problem;
  problem.draw(0.4, 0.7, RandomStream{3, 1});
  double widest = 0;
  const Assessment found = widened(problem, widest);
  double mean[2] = {}, square[2] = {};
  for (size_t g = 0; g < kGroups; ++g) {
    const auto [level, slope] = line_without(problem, g);
    mean[0] += level / kGroups, mean[1] += slope / kGroups;
  }
  for (size_t g = 0; g < kGroups; ++g) {
    const auto [level, slope] = line_without(problem, g);
    square[0] += std::pow(level - mean[0], 2), square[1] += std::pow(slope - mean[1], 2);
  }
  for (size_t k = 0; k < 2; ++k) {
    const double by_hand = std::sqrt((kGroups - 1.0) / kGroups * square[k]);
    EXPECT_NEAR(found.fit.sigma[k], by_hand, 1e-3 * by_hand) << k;
    EXPECT_NEAR(std::sqrt(found.fit.covariance[3 * k]), found.fit.sigma[k], 1e-12);
  }
  EXPECT_GT(widest, 1.5);
}

TEST(GroupScatter, CoversTheTruthWhereGroupsDiffer) {
  constexpr int kDraws = 300;
  double far = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Runs problem;
    problem.draw(0.4, 0.7, RandomStream{static_cast<uint64_t>(draw), 2});
    double widest = 0;
    const Assessment found = widened(problem, widest);
    for (size_t k = 0; k < 2; ++k) {
      const double z = found.fit.value[k] / found.fit.sigma[k];
      far += std::abs(z) > 2.776 ? 1 : 0;  // 95 % of Student's t with 4 degrees.
    }
  }
  EXPECT_NEAR(far / (2 * kDraws), 0.05, 0.025);
}

// Two runs, whose residuals are alike over some twenty rows: the scatter of two says nothing.
TEST(GroupScatter, StretchesOfFewGroupsTellWhatHangsTogether) {
  constexpr int kDraws = 200;
  constexpr size_t kRows = 1200;
  constexpr double kKept = 0.9;  // From one row to the next.
  std::vector<double> x;
  for (size_t i = 0; i < kRows; ++i) x.push_back(std::sin(0.7 * static_cast<double>(i)));
  double far = 0;
  for (uint64_t draw = 0; draw < kDraws; ++draw) {
    MadeProblem problem(x, kRunNoise,
                        [](const std::vector<double>& p, double at) { return p[0] + p[1] * at; });
    problem.cut_into(2);
    const RandomStream stream{draw, 5};
    std::vector<double> y;
    double alike = 0;
    for (size_t i = 0; i < kRows; ++i) {
      alike = kKept * alike + kRunNoise * normal(stream, i);
      y.push_back(alike);
    }
    problem.take(std::move(y));
    Assessment found = assess(problem, line_of(0, 0), kLevelAndSlope);
    EXPECT_GT(found.error, kAdequate);
    widen_by_group_scatter(problem, kAdequate, found);
    const double z = found.fit.value[0] / found.fit.sigma[0];
    far += std::abs(z) > 2.365 ? 1 : 0;  // 95 % of Student's t with 7 degrees; 59 % else.
  }
  EXPECT_NEAR(far / kDraws, 0.05, 0.04);
}

// Rows of a group that go together by half a noise are no misfit, and their mean is told far worse
// than that of independent ones.
TEST(GroupScatter, WidensAtTheNoiseWhereGroupsDifferBeyondChance) {
  int at_noise = 0, wider = 0;
  for (uint64_t draw = 0; draw < 40; ++draw) {
    Runs problem;
    problem.draw(0.5 * kRunNoise, 0, RandomStream{draw, 4});
    double widest = 0;
    const Assessment found = widened(problem, widest);
    if (found.error > kAdequate) continue;
    ++at_noise;
    if (widest > 1) ++wider;
  }
  EXPECT_GT(at_noise, 10);
  EXPECT_GT(2 * wider, at_noise);
}

TEST(GroupScatter, LeavesErrorsAloneWhereTheModelIsRight) {
  int wider = 0;
  for (uint64_t draw = 0; draw < 40; ++draw) {
    Runs problem;
    problem.draw(0, 0, RandomStream{draw, 3});
    double widest = 0;
    const Assessment found = widened(problem, widest);
    if (widest > 1) {
      ++wider;  // The noise of 150 rows is taken for a misfit once in a hundred times.
      continue;
    }
    const Fit plain = problem.fit(found.model, kLevelAndSlope, problem.all_groups());
    EXPECT_NEAR(found.fit.sigma[0], plain.sigma[0], 1e-9);
    EXPECT_NEAR(found.fit.sigma[1], plain.sigma[1], 1e-9);
  }
  EXPECT_LE(wider, 2);
}

}  // namespace
}  // namespace seam::measurement
