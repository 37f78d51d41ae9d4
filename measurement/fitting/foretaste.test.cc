// Few groups tell how good a fit to all can be, and never less than it is.
#include "measurement/fitting/foretaste.h"

#include <gtest/gtest.h>

#include <cmath>

#include "measurement/fitting/few_groups.h"
#include "measurement/problem/made_problem.h"

namespace seam::measurement {
namespace {

// A line with an offset, in groups of as many rows each, of one channel.
class ManyRows : public MadeProblem {
 public:
  ManyRows(size_t rows, size_t groups)
      : MadeProblem(evenly(-1, 1, rows), 0.3,
                    [](const std::vector<double>& p, double x) { return p[0] + p[1] * x; }) {
    deal_into(groups);
  }
};

Model line(double offset, double slope) {
  return made_model(made_effect("line", {{.name = "offset", .min = -9, .max = 9, .scale = 1},
                                         {.name = "slope", .min = -9, .max = 9, .scale = 1}}),
                    {offset, slope});
}

const std::vector<Unknown> kBoth = {{"line", 0}, {"line", 1}};

TEST(Foretaste, AsksSoManyRowsThatWhatMattersIsPlain) {
  const ManyRows problem(80000, 200);
  const Groups training = problem.training_groups();
  const auto rows = [&](double material) {
    const auto few = enough_to_tell(problem, line(0, 0), training, material);
    double count = 0;
    for (size_t g = 0; few && g < few->groups.size(); ++g) count += few->groups[g] ? 400 : 0;
    return count;
  };
  // 20 units of likelihood, where each row gains material^2 / 2.
  EXPECT_GE(rows(0.1), 4000);
  EXPECT_LE(rows(0.1), 4400);
  EXPECT_GE(rows(0.2), 1000);
  EXPECT_EQ(rows(0), 0) << "where nothing is small, all rows are asked";
  EXPECT_EQ(rows(0.02), 0) << "100,000 rows are more than there are";
  EXPECT_FALSE(foretasters(ManyRows(80000, 7), line(0, 0), 0.1))
      << "few groups stand for no others";
  EXPECT_FALSE(foretasters(ManyRows(5000, 200), line(0, 0), 0.1));
}

// The promise that lets fits stay where few groups leave them: over many made sets no fit to all
// rows was ever better than what the few said it may reach, and it is often not much worse.
TEST(Foretaste, PromisesNoLessThanAllRowsGive) {
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    ManyRows problem(24000, 120);
    problem.observe(line(0.2, 1.7), {.seed = seed});
    const auto few = foretasters(problem, line(0, 0), 0.1);
    ASSERT_TRUE(few);
    const Foretaste taste = foretaste(problem, *few, line(0, 0), kBoth);
    const Assessment whole = assess(problem, line(0, 0), kBoth);
    EXPECT_LE(taste.assessment.total_ll, whole.total_ll + 2);
    EXPECT_GE(taste.most_ll, whole.total_ll) << seed;
    EXPECT_LE(taste.most_ll, whole.total_ll + 100);
    EXPECT_FALSE(stays_below(problem, line(0, 0), kBoth, whole.total_ll));
    EXPECT_TRUE(stays_below(problem, line(0, 0), kBoth, whole.total_ll + 500));
  }
}

}  // namespace
}  // namespace seam::measurement
