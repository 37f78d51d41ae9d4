// What speaks against effects that were named.
#include "measurement/judge/doubted.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "measurement/problem/made_problem.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kNoiseOfLine = 0.1;

std::shared_ptr<const EffectDefinition> of_size(const std::string& name) {
  return made_effect(name, {{.name = "size", .min = -100, .max = 100, .scale = 1}});
}

// y = a x + b (x + x^3 / 100): the two act nearly alike.
double nearly_alike(const std::vector<double>& p, double x) {
  return (p.empty() ? 0 : p[0] * x) + (p.size() > 1 ? p[1] * (x + 0.01 * x * x * x) : 0);
}

Assessment of_two(double a, double b) {
  Assessment best;
  best.model.set(of_size("line"), {{.value = a}});
  best.model.set(of_size("bent"), {{.value = b}});
  best.unknowns = {{"line", 0}, {"bent", 0}};
  return best;
}

TEST(Doubted, EffectsThatOnlyCancelEachOther) {
  MadeProblem problem(evenly(-1, 1, 100), kNoiseOfLine, nearly_alike);
  problem.observe(of_two(5, -5).model, {7, 1});
  const auto doubts = doubts_of(problem, of_two(5, -5), {"line", "bent"});
  ASSERT_EQ(doubts.size(), 2u);
  for (const auto& of_one : doubts) EXPECT_THAT(of_one, ElementsAre(HasSubstr("others cancel it")));
  // Of two that add up, or of one alone, nothing is said.
  EXPECT_THAT(doubts_of(problem, of_two(5, 5), {"line", "bent"}),
              ElementsAre(IsEmpty(), IsEmpty()));
  EXPECT_THAT(doubts_of(problem, of_two(5, -5), {"line"}), ElementsAre(IsEmpty()));
}

TEST(Doubted, AValueBeyondWhatPeopleHave) {
  const auto known = made_effect("line", {{.name = "size",
                                           .min = -100,
                                           .max = 100,
                                           .scale = 1,
                                           .plausible = {-2, 2, "somebody who knows"}}});
  const auto line = [](const std::vector<double>& p, double x) { return p[0] * x; };
  const auto doubts_of_size = [&](double size, double sigma) {
    MadeProblem problem(evenly(-1, 1, 100), kNoiseOfLine, line);
    Assessment best{.model = made_model(known, {size}), .unknowns = {{"line", 0}}};
    problem.observe(best.model, {7, 5});
    best.fit.sigma = {sigma};
    return doubts_of(problem, best, {"line"}).at(0);
  };
  EXPECT_THAT(doubts_of_size(2.5, 0.01), ElementsAre(HasSubstr("beyond the plausible -2 to 2")));
  EXPECT_THAT(doubts_of_size(1.9, 0.01), IsEmpty());
  EXPECT_THAT(doubts_of_size(2.5, 1), IsEmpty());  // Within its error.
}

TEST(Doubted, AValueThatOneGroupMakes) {
  const auto line = [](const std::vector<double>& p, double x) { return p[0] * x; };
  Model none = made_model(of_size("line"), {0});
  const auto doubts_with = [&](double slope_of_one, double slope_of_others = 0) {
    MadeProblem problem(evenly(-1, 1, 240), kNoiseOfLine, line);
    problem.deal_into(6);
    std::vector<double> y;
    for (size_t i = 0; i < 240; ++i)
      y.push_back((i % 6 == 4 ? slope_of_one : slope_of_others) * problem.x()[i] +
                  kNoiseOfLine * normal({7, 3}, i));
    problem.take(std::move(y));
    Assessment best{.model = none, .unknowns = {{"line", 0}}};
    best.fit = problem.fit(none, best.unknowns, problem.all_groups());
    best.model = best.fit.model;
    return doubts_of(problem, best, {"line"})[0];
  };
  EXPECT_THAT(doubts_with(0.5), ElementsAre(HasSubstr("of its errors without g4")));
  EXPECT_THAT(doubts_with(0), IsEmpty());
  EXPECT_THAT(doubts_with(4.5, 4), IsEmpty());  // All make it, and one a little more.
}

TEST(Doubted, AValueAtTheEndOfItsRange) {
  MadeProblem problem(evenly(-1, 1, 50), kNoiseOfLine, nearly_alike);
  EXPECT_THAT(doubts_of(problem, of_two(100, 1), {"line"})[0],
              ElementsAre("size = 100 is at the end of its range"));
}

}  // namespace
}  // namespace seam::measurement
