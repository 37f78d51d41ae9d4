#include "measurement/infer/unnamed.h"

#include <gtest/gtest.h>

#include <cmath>

#include "measurement/infer/smooth_field.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/problem/made_problem.h"

namespace seam::measurement {
namespace {

constexpr double kNoise = 0.5, kMaterialShare = 0.1;

// y = level + bend(x) + noise; the bend has no name.
class Bent : public MadeProblem {
 public:
  explicit Bent(double bend, uint64_t seed = 1)
      : MadeProblem(evenly(-1, 1, 600), kNoise, [](const std::vector<double>& p, double x) {
          return p[0] + (p.size() > 1 ? p[1] * x * x * x : 0) +
                 (p.size() > 2 ? p[2] * std::cos(5 * x) : 0);
        }) {
    deal_into(12);
    facts_.covariates = {{.name = "x", .values = x()}, {.name = "other", .values = other()}};
    std::vector<double> y;
    for (size_t i = 0; i < x().size(); ++i)
      y.push_back(bend * std::cos(5 * x()[i]) + kNoise * normal({seed, 2}, i));
    take(std::move(y));
  }

  static Model level() {
    return made_model(made_effect("level", {{.name = "y", .min = -9, .max = 9}}), {0});
  }
  // What is not in the formula, and bends the other way.
  static Model with_cube() {
    Model model = level();
    model.set(made_effect("cube", {{.name = "size", .min = -9, .max = 9}}), {{.value = 0}});
    return model;
  }
  // With the bend itself, in the place of a noise that takes all that is left.
  static Model with_all() {
    Model model = with_cube();
    model.set(made_effect("wave", {{.name = "size", .min = -9, .max = 9}}), {{.value = 0}});
    return model;
  }
  Assessment fitted(const Model& model) const {
    std::vector<Unknown> unknowns;
    for (const effects::ModelEffect& effect : model.effects())
      unknowns.push_back({effect.definition->name, 0});
    return assess(*this, model, unknowns);
  }

 private:
  static std::vector<double> other() {
    std::vector<double> values;
    for (size_t i = 0; i < 600; ++i) values.push_back(normal({9, 9}, i));
    return values;
  }
};

std::optional<UnnamedCause> cause_of(const Bent& problem, const std::vector<Assessment>& ways) {
  std::vector<Explanation> explanations;
  for (const Assessment& way : ways) {
    const double price = 0.5 * std::log(600) * static_cast<double>(way.unknowns.size());
    explanations.push_back({&way, way.total_ll - price});
  }
  return unnamed_cause(problem, explanations, kMaterialShare, KnownCauses{1});
}

TEST(Unnamed, ACauseThatNoEffectDescribesIsFoundByWhatItDependsOn) {
  const Bent problem(0.5);
  const auto cause = cause_of(problem, {problem.fitted(Bent::level())});
  ASSERT_TRUE(cause);
  EXPECT_EQ(cause->depends_on, std::vector<std::vector<std::string>>{{"x"}});
  EXPECT_EQ(cause->beside, 0u);
  // The root mean square of 0.5 cos(5 x) less its mean is 0.66 noises; the prior takes a twentieth,
  // and 600 rows leave a standard error of 0.04.
  EXPECT_NEAR(cause->noise_units, 0.63, 0.12);
  EXPECT_NEAR(cause->error_after, 1, 0.05);
  EXPECT_GT(cause->takes, 0.8);
}

TEST(Unnamed, AnEffectThatOnlyImitatesItLoses) {
  const Bent problem(0.5);
  const auto cause =
      cause_of(problem, {problem.fitted(Bent::level()), problem.fitted(Bent::with_cube())});
  ASSERT_TRUE(cause);
  EXPECT_EQ(cause->beside, 0u);
  EXPECT_GT(cause->lead, 50);
}

// Values of training groups are short of the best of all: no cause is ahead for that.
TEST(Unnamed, AnExplanationCountsAsFittedToAllGroups) {
  const Bent problem(0.5);
  const Assessment last = problem.fitted(Bent::with_cube());
  const auto lead_beside = [&](double off) {
    Assessment given = problem.fitted(Bent::level());
    given.model.set_value("level", 0, given.model.find("level")->value("y") + off);
    const double ll = problem.score(given.model, problem.all_groups()).log_likelihood;
    return unnamed_cause(problem, {{&given, ll}, {&last, last.total_ll}}, kMaterialShare,
                         KnownCauses{1})
        ->lead;
  };
  EXPECT_NEAR(lead_beside(0.1), lead_beside(0), 1e-6);
}

// Noise of unknown cause that is little ahead, by the step's falling short of a fit, names nothing.
TEST(Unnamed, AFunctionTakesThePlaceOfNoiseThatTakesWhatItTakes) {
  const Bent problem(0.5);
  const Assessment given = problem.fitted(Bent::level()), all = problem.fitted(Bent::with_all());
  const auto gain = unnamed_cause(problem, {{&given, 0}}, kMaterialShare, KnownCauses{1})->lead;
  const auto beside_noise = [&](double share, bool is_noise) {
    return unnamed_cause(problem, {{&given, 0, is_noise}, {&all, share * gain}}, kMaterialShare,
                         KnownCauses{1});
  };
  EXPECT_TRUE(beside_noise(1.02, true));
  EXPECT_FALSE(beside_noise(1.02, false));
  EXPECT_FALSE(beside_noise(1.2, true));
}

TEST(Unnamed, NoiseAloneHasNoCause) {
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    const Bent problem(0, seed);
    EXPECT_FALSE(cause_of(problem, {problem.fitted(Bent::level())})) << seed;
  }
}

TEST(Unnamed, ATraceIsNotMaterial) {
  const Bent problem(0.03);
  EXPECT_FALSE(cause_of(problem, {problem.fitted(Bent::level())}));
}

TEST(SmoothField, ColumnsAreOfTheSizeOfTheNoise) {
  const Bent problem(0);
  const Evaluation here = problem.evaluate(Bent::level(), problem.all_groups());
  const auto places = places_in_channels(problem, here);
  const auto fields = smooth_fields(places);
  ASSERT_EQ(fields.size(), 3u);  // x, x and other, other.
  for (const SmoothField& field : fields) {
    const FieldColumns columns = columns_of(problem.facts(), field);
    double rough2 = 0, smooth2 = 0;
    for (size_t k = 0; k < columns.values.size(); ++k) {
      for (const double value : columns.values[k]) {
        const double share = value * value / static_cast<double>(columns.values[k].size());
        rough2 += share, smooth2 += share * std::pow(columns.smoother[k], 2);
      }
    }
    for (const double sum2 : {rough2, smooth2}) {
      EXPECT_GT(sum2, 0.1);
      EXPECT_LT(sum2, 2);
    }
  }
}

// Where nearly all values are cut off, fewer are left than parameters.
TEST(ColumnBasis, MoreColumnsThanRowsSpanAllThereIs) {
  const Eigen::MatrixXd wide{{1, 2, 3}, {0, 1, -1}};
  const Eigen::MatrixXd basis = column_basis(wide, 1e-6);
  ASSERT_EQ(basis.cols(), 2);
  EXPECT_LT((basis * basis.transpose() * wide - wide).norm(), 1e-12);
  EXPECT_EQ(column_basis(Eigen::MatrixXd(0, 3), 1e-6).cols(), 0);
}

TEST(SmoothField, AConstantCovariateGivesNone) {
  FieldPlace place{.slopes = {std::vector<double>(3, 1)},
                   .covariates = {{.name = "same", .values = {2, 2, 2}}}};
  Facts facts;
  facts.row_of = {0, 1, 2};
  EXPECT_TRUE(columns_of(facts, {&place, {&place.covariates[0]}}).values.empty());
}

}  // namespace
}  // namespace seam::measurement
