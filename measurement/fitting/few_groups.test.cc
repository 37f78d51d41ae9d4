// A fit to many rows goes most of its way on a few groups, and ends where all rows say.
#include "measurement/fitting/few_groups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "measurement/problem/made_problem.h"

namespace seam::measurement {
namespace {

// A line through zero, in groups of as many rows each, which may be said to share errors.
class GroupedLine : public MadeProblem {
 public:
  GroupedLine(size_t rows, size_t groups, bool independent = true)
      : MadeProblem(evenly(-1, 1, rows), 0.3,
                    [](const std::vector<double>& p, double x) { return p[0] * x; }),
        independent_(independent) {
    deal_into(groups);
  }
  bool groups_are_independent(const Model&) const override { return independent_; }

 private:
  bool independent_;
};

Model slope_of(double value) {
  return made_model(made_effect("line", {{.name = "slope", .min = -9, .max = 9, .scale = 1}}),
                    {value});
}

size_t count_of(const Groups& groups) {
  return static_cast<size_t>(std::count(groups.begin(), groups.end(), 1));
}

TEST(FewGroups, AreSomeOfThoseThatAreFitted) {
  const GroupedLine problem(60000, 120);
  Groups groups = problem.all_groups();
  for (size_t g = 0; g < groups.size(); g += 3) groups[g] = 0;
  const auto few = few_of(problem, slope_of(0), groups);
  ASSERT_TRUE(few);
  EXPECT_GE(count_of(few->groups), 6u);
  EXPECT_LT(count_of(few->groups), count_of(groups) / 2);
  for (size_t g = 0; g < groups.size(); ++g) EXPECT_LE(few->groups[g], groups[g]);
  EXPECT_EQ(few->groups, few_of(problem, slope_of(1), groups)->groups);
}

TEST(FewGroups, AreNoneWhereTheySaveLittleOrDoNotStandForAll) {
  const auto few = [](const GroupedLine& problem) {
    return few_of(problem, slope_of(0), problem.all_groups()).has_value();
  };
  EXPECT_TRUE(few(GroupedLine(60000, 120)));
  EXPECT_FALSE(few(GroupedLine(3000, 120)));
  EXPECT_FALSE(few(GroupedLine(60000, 8)));
  EXPECT_FALSE(few(GroupedLine(60000, 120, /*independent=*/false)));
}

TEST(FewGroups, LeadAFitToWhereAllRowsSay) {
  GroupedLine problem(60000, 120);
  problem.observe(slope_of(1.7), {.seed = 3});
  double xx = 0, xy = 0;
  for (size_t i = 0; i < problem.x().size(); ++i)
    xx += problem.x()[i] * problem.x()[i], xy += problem.x()[i] * problem.y()[i];
  const double sigma = 0.3 / std::sqrt(xx);
  const Fit fit = problem.fit(slope_of(0), {{"line", 0}}, problem.all_groups());
  EXPECT_NEAR(fit.value[0], xy / xx, 1e-3 * sigma);
  EXPECT_NEAR(fit.sigma[0], sigma, 0.02 * sigma);
}

}  // namespace
}  // namespace seam::measurement
