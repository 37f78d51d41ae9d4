// Parameters that do the same to all predictions are named, and one of them is not freed.
#include "measurement/search/told_apart.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "effects/registry.h"
#include "measurement/judge/judge.h"
#include "measurement/kinds/kinds.h"
#include "measurement/numerics/span.h"
#include "measurement/problem/made_problem.h"
#include "measurement/search/choice.h"
#include "measurement/search/exchanges.h"
#include "measurement/search/models/add_effects.h"
#include "measurement/search/search.h"
#include "measurement/study/study.h"

namespace seam::measurement {
namespace {

TEST(Span, LeavesWhatIsOrthogonal) {
  Span span;
  span.add({3, 4, 0});
  std::vector<double> column = {1, 0, 2};
  EXPECT_NEAR(span.take_out_of(column), std::sqrt(5.0), 1e-15);
  // (1, 0, 2) less 0.6 of the unit vector (0.6, 0.8, 0).
  EXPECT_NEAR(column[0], 0.64, 1e-15);
  EXPECT_NEAR(column[1], -0.48, 1e-15);
  EXPECT_NEAR(column[2], 2, 1e-15);
  EXPECT_NEAR(length(column), std::sqrt(0.64 + 4), 1e-15);
}

// What is left of the target is orthogonal to each column as it was given.
TEST(Span, StepsLeadNearest) {
  const std::vector<std::vector<double>> columns = {{1, 2, 0, 1}, {2, 1, 3, 0}, {0, 1, 1, 5}};
  Span span;
  std::vector<double> parts;
  for (std::vector<double> column : columns) {
    span.take_out_of(column, &parts);
    span.add(column, parts);
  }
  std::vector<double> left = {3, -1, 4, 2};
  const std::vector<double> steps = span.steps_to(left);
  ASSERT_EQ(steps.size(), columns.size());
  for (size_t k = 0; k < columns.size(); ++k) {
    for (size_t i = 0; i < left.size(); ++i) left[i] -= steps[k] * columns[k][i];
  }
  EXPECT_GT(length(left), 1);
  for (const auto& column : columns) EXPECT_NEAR(dot(left, column), 0, 1e-13);
}

// A model that discover found has the focal length twice: in the lens, and as an error of it.
TEST(Refit, AFocalLengthBesideItsErrorIsNotFreed) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "refit-focal";
  const Model nominal = write_study_protocol("points", folder / "protocol");
  const auto effect = effects::find_effect("focal_length_error");
  Model model = nominal;
  std::vector<effects::ParameterValue> values(effect->parameters.size());
  for (size_t i = 0; i < values.size(); ++i)
    values[i] = {.value = effect->parameters[i].neutral, .sigma = 1e-3};
  values[0].value += 0.01;
  model.set(effect, values);
  measure_set(model, MeasurementSet::open(folder / "protocol"), {.seed = 4, .out = folder / "set"});
  const auto problem = open_problem(folder / "set");
  const AddResult result = refit_all(*problem, model);
  ASSERT_FALSE(result.not_testable.empty());
  for (const NotTestable& untold : result.not_testable) {
    EXPECT_EQ(untold.effect, "pinhole");  // What was fitted before stays free.
    EXPECT_NE(untold.why.find("focal_length_error"), std::string::npos) << untold.why;
  }
  bool checked = false;
  for (const auto& [name, value] : result.parameters) {
    if (name.find("focal_length_error") == std::string::npos) continue;
    ASSERT_TRUE(value.sigma);
    EXPECT_LT(*value.sigma, 0.01) << name;  // It was 1e3 and more.
    checked = true;
  }
  EXPECT_TRUE(checked);
  EXPECT_NEAR(result.error_after, 1, 0.1);
}

// A swing of no size has a phase far from neutral, and may go.
TEST(ClearlyNeeded, IsWhatHasASize) {
  const auto swing = made_effect("swing", {{.name = "size", .min = -9, .max = 9, .scale = 1},
                                           {.name = "phase_rad", .min = -9, .max = 9, .scale = 1}});
  const auto needed = [&](double size) {
    Grown grown{.added = {"swing"}};
    grown.assessment.model = made_model(swing, {size, 1.6});
    grown.assessment.unknowns = {{"swing", 0}, {"swing", 1}};
    grown.assessment.fit.value = {size, 1.6};
    grown.assessment.fit.sigma = {0.01, 0.1};
    return clearly_needed(grown, "swing");
  };
  EXPECT_FALSE(needed(0.02));
  EXPECT_TRUE(needed(0.2));
  EXPECT_TRUE(needed(-0.2));
}

// y = x by one of two effects, a straight one and one that is bent by up to a fifth, where
// predictions are exact to `accuracy`.
class StraightOrBent : public MadeProblem {
 public:
  explicit StraightOrBent(double accuracy)
      : MadeProblem(evenly(-1, 1, 2000), 0.5,
                    [](const std::vector<double>&, double) { return 0.0; }),
        accuracy_(accuracy) {
    deal_into(20);
    std::vector<double> y;
    for (size_t i = 0; i < x().size(); ++i) y.push_back(x()[i] + 0.5 * normal({3, 1}, i));
    take(std::move(y));
    prepare(flat());
  }
  static Model flat() {
    return made_model(made_effect("none", {{.name = "none", .min = -1, .max = 1}}), {0});
  }
  static EffectList effects() {
    const effects::Parameter size{.name = "size", .min = -100, .max = 100, .scale = 1};
    return {made_effect("straight", {size}), made_effect("bent", {size})};
  }
  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* = nullptr) const override {
    Evaluation out;
    out.sigma.assign(x().size(), 0.5);
    for (size_t i = 0; i < x().size(); ++i) {
      const double at = x()[i];
      const auto by = [&](const char* name, double shape) {
        return model.has(name) ? model.find(name)->values()[0] * shape : 0.0;
      };
      out.residual.push_back(y()[i] - by("straight", at) - by("bent", at * (1 + 0.2 * at)));
    }
    whiten_diagonal(*this, groups, out);
    return out;
  }
  bool is_visible(const Model& a, const Model& b) const override {
    const Evaluation here = evaluate(a, all_groups()), there = evaluate(b, all_groups());
    double most = 0;
    for (size_t i = 0; i < x().size(); ++i)
      most = std::max(most, std::abs(here.residual[i] - there.residual[i]));
    return most > accuracy_;
  }
  bool acts(const EffectDefinition& effect) const override {
    return effect.name == "straight" || effect.name == "bent";
  }
  std::vector<std::vector<double>> starts(const Model&, const EffectDefinition&) const override {
    return {{0.1}};
  }

 private:
  double accuracy_;
};

// However much likelier one of them is.
TEST(ToldApart, EffectsThatPredictTheSameAsFarAsPredictionsAreExactAreTied) {
  for (const double accuracy : {0.1, 0.3}) {
    StraightOrBent problem(accuracy);
    const SearchResult result = search(problem, StraightOrBent::flat(), StraightOrBent::effects(),
                                       [](const std::string&) {});
    ASSERT_EQ(result.steps.size(), 1u);
    EXPECT_EQ(result.steps[0].effect, "straight");
    EXPECT_EQ(result.steps[0].indistinguishable_from,
              accuracy > 0.2 ? std::vector<std::string>{"bent"} : std::vector<std::string>{});
  }
}

// y = x and noise, by an effect that is linear: one step ends where least squares do.
TEST(Prospect, AStepOfALinearEffectEndsAtItsLeastSquares) {
  class Smooth : public StraightOrBent {
   public:
    using StraightOrBent::StraightOrBent;
    bool is_smooth(const Model&) const override { return true; }
  };
  const Smooth problem(0);
  const Grown base{.assessment = assess_fixed(problem, Smooth::flat())};
  std::vector<NotTestable> reasons;
  const auto prospect = prospect_of(problem, base, Smooth::effects()[0], reasons);
  ASSERT_TRUE(prospect && prospect->step_to);
  double xx = 0, xy = 0;
  for (size_t i = 0; i < problem.x().size(); ++i) {
    xx += problem.x()[i] * problem.x()[i];
    xy += problem.x()[i] * problem.y()[i];
  }
  EXPECT_NEAR(prospect->step_to->find("straight")->values()[0], xy / xx, 1e-9);
  EXPECT_NEAR(prospect->expected_ll - base.assessment.total_ll, xy * xy / xx / (2 * 0.5 * 0.5),
              1e-6);
  EXPECT_NEAR(problem.score(*prospect->step_to, problem.all_groups()).log_likelihood,
              prospect->expected_ll, 1e-6);
}

// Values of a quotient of polynomials that have a factor in common predict the same as those of the
// quotient without it, of which coarse derivatives know nothing.
class Quotient : public testing::Test {
 protected:
  Quotient() {
    problem_.deal_into(20);
    problem_.observe(made_model(effect_, kTruth), {7, 1});
    problem_.prepare(made_model(effect_, kTruth));
  }
  Grown fitted_from(const std::vector<double>& values, const std::vector<size_t>& free) const {
    Grown grown{.added = {"quotient"}};
    std::vector<Unknown> unknowns;
    for (const size_t i : free) unknowns.push_back({"quotient", i});
    grown.assessment = assess(problem_, made_model(effect_, values), unknowns);
    return grown;
  }
  static double above(const std::vector<double>& p, double t) {
    return (1 + t * (p[0] + t * p[1])) / (1 + t * (p[2] + t * p[3]));
  }
  void expect_simplest(const Grown& grown) const {
    const effects::Values values = grown.assessment.model.find("quotient")->values();
    EXPECT_EQ(values[3], 0);
    for (size_t k = 0; k < grown.assessment.unknowns.size(); ++k)
      EXPECT_NEAR(values[grown.assessment.unknowns[k].parameter],
                  kTruth[grown.assessment.unknowns[k].parameter],
                  4 * grown.assessment.fit.sigma[k]);
  }

  const std::vector<double> kTruth = {0.4, 0, 0.7, 0};
  static std::shared_ptr<const EffectDefinition> quotient(double most_of_b) {
    return made_effect("quotient", {{.name = "a", .min = -50, .max = 50, .scale = 0.1},
                                    {.name = "b", .min = -50, .max = most_of_b, .scale = 0.1},
                                    {.name = "c", .min = -50, .max = 50, .scale = 0.1},
                                    {.name = "d", .min = -50, .max = 50, .scale = 0.1}});
  }
  std::shared_ptr<const EffectDefinition> effect_ = quotient(50);
  struct Smooth : MadeProblem {
    using MadeProblem::MadeProblem;
    bool is_smooth(const Model&) const override { return true; }
  } problem_{evenly(0, 20, 2000), 1e-5, above};
};

TEST_F(Quotient, AFactorInCommonGoes) {
  // (1 + 0.4 t) (1 + 0.3 t) over (1 + 0.7 t) (1 + 0.3 t).
  const Grown found = fitted_from({0.7, 0.12, 1.0, 0.21}, {0, 1, 2, 3});
  ASSERT_LT(found.assessment.error, 1.1);
  expect_simplest(less_tangled(problem_, found));
}

// Bounds are those of coefficients of powers: of two that do the same the higher power goes, though
// it stands before the other.
TEST_F(Quotient, TheWidestBoundsGoFirst) {
  effect_ = quotient(200);
  const Grown found = less_tangled(problem_, fitted_from({0.7, 0.12, 1.0, 0.21}, {0, 1, 2, 3}));
  EXPECT_LT(found.assessment.error, 1.1);
  EXPECT_EQ(found.assessment.model.find("quotient")->values()[1], 0);
}

// A form in which a higher power stands for one that was left out.
TEST_F(Quotient, ALowerPowerComesInThePlaceOfAHigher) {
  effect_ = quotient(200);
  const std::vector<double> truth = {0.4, 0, 0.7, 0.05};
  problem_.observe(made_model(effect_, truth), {7, 2});
  const Grown found = less_tangled(problem_, fitted_from({0.4, 0.01, 0.7, 0}, {0, 1, 2}));
  EXPECT_LT(found.assessment.error, 1.1);
  const effects::Values values = found.assessment.model.find("quotient")->values();
  EXPECT_EQ(values[1], 0);
  EXPECT_NEAR(values[3], truth[3], 0.001);
}

// Of several exchanges the one that is most ahead comes, unless held-out groups deny it; what two
// fits of one model may differ by moves nothing.
TEST(Exchange, WhatIsClearlyAheadComes) {
  const auto with = [](double total, double held) {
    Grown g;
    g.assessment.total_ll = total, g.assessment.held.log_likelihood = held;
    g.assessment.error = 1;
    return std::optional(g);
  };
  const Grown here = *with(1000, 300);
  EXPECT_FALSE(best_exchange(here, {std::nullopt, with(1001, 300)}));
  EXPECT_EQ(best_exchange(here, {with(1002, 300), with(1003, 300), std::nullopt}), 1u);
  EXPECT_EQ(best_exchange(here, {with(1002, 299), with(1003, 297)}), 0u);
}

TEST(Exchange, ALensMayGoForANarrowerOne) {
  const auto may = [](const std::string& leaving, const std::string& in) {
    return stands_for(*effects::find_effect(leaving), *effects::find_effect(in));
  };
  EXPECT_TRUE(may("rational_lens", "radial_polynomial"));
  EXPECT_TRUE(may("radial_polynomial", "radial_distortion"));
  EXPECT_TRUE(may("fisheye", "rational_lens"));
  EXPECT_FALSE(may("radial_polynomial", "rational_lens"));
  EXPECT_FALSE(may("thin_prism", "radial_distortion"));
}

}  // namespace
}  // namespace seam::measurement
