// Whether errors are what they say: over many small made sets, estimates lie within two of their
// own standard errors of the truth as often as a normal distribution has it.
#include <gtest/gtest.h>

#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "effects/registry.h"
#include "measurement/fitting/wide_fit.h"
#include "measurement/kinds/kinds.h"
#include "measurement/problem/made_problem.h"
#include "measurement/study/study.h"

namespace seam::measurement {
namespace {

// Estimates in units of their own errors from the truth.
struct Scores {
  int within = 0, trials = 0;

  void add(double estimate, double sigma, double truth) {
    ASSERT_TRUE(std::isfinite(sigma) && sigma > 0) << estimate << " +- " << sigma;
    const double z = (estimate - truth) / sigma;
    within += std::abs(z) < 2, ++trials;
  }

  // The share of a normal distribution, 95.45 %, gives a count in this band in all but one of a
  // thousand seeds.
  void expect_normal(const std::string& what) const {
    const boost::math::binomial counts(trials, std::erf(std::sqrt(2.0)));
    EXPECT_GE(within, quantile(counts, 0.0005)) << what << ", of " << trials;
    EXPECT_LE(within, quantile(complement(counts, 0.0005))) << what << ", of " << trials;
  }
};

// Sets of the studies' protocols, with this effect at work and fitted.
Scores of_sets(const std::string& kind, const std::string& effect, const std::vector<double>& truth,
               int seeds) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("coverage-" + kind);
  const Model nominal = write_study_protocol(kind, folder / "protocol");
  const auto definition = effects::find_effect(effect);
  Model model = nominal, start = nominal;
  std::vector<effects::ParameterValue> values;
  std::vector<Unknown> unknowns;
  for (size_t i = 0; i < truth.size(); ++i) {
    values.push_back({.value = truth[i]});
    unknowns.push_back({effect, i});
  }
  model.set(definition, values);
  start.add_neutral(definition);
  const MeasurementSet protocol = MeasurementSet::open(folder / "protocol");
  Scores scores;
  for (int seed = 1; seed <= seeds; ++seed) {
    std::filesystem::remove_all(folder / "set");
    measure_set(model, protocol, {.seed = static_cast<uint64_t>(seed), .out = folder / "set"});
    const auto problem = open_problem(folder / "set");
    problem->prepare(nominal);
    const Fit fit = problem->fit(start, unknowns, problem->all_groups());
    for (size_t i = 0; i < truth.size(); ++i) scores.add(fit.value[i], fit.sigma[i], truth[i]);
  }
  return scores;
}

TEST(Coverage, OfErrorsOfSets) {
  const Scores points = of_sets("points", "rolling_shutter", {4e-5}, 60);
  points.expect_normal("points");
  const Scores landmarks = of_sets("landmarks", "range_scale", {0.02}, 60);
  landmarks.expect_normal("landmarks");
  const Scores odometry = of_sets("odometry", "odometry_scale", {0.05, -0.03, 0.02}, 60);
  odometry.expect_normal("odometry");
  const Scores joints = of_sets("joints", "servo_lag", {0.03}, 60);
  joints.expect_normal("joints");
  Scores all;
  for (const Scores& part : {points, landmarks, odometry, joints})
    all.within += part.within, all.trials += part.trials;
  all.expect_normal("all");
}

// Lines and a noise beside the stated one, 600 sets for each fit: enough to see an error bar that
// is a seventh too short (91.4 % within two) or too long. Rows are many, since the spread of few is
// known to have Student's tails, and centred, so that the line's two parameters are independent.
TEST(Coverage, OfErrorsOfMadeSets) {
  const auto line = made_effect("line", {{.name = "a", .min = -100, .max = 100, .scale = 1},
                                         {.name = "b", .min = -100, .max = 100, .scale = 0.1}});
  const auto noise =
      made_effect("more", {{.name = "sigma", .min = 0, .max = 100, .scale = 1}}, true);
  MadeProblem problem(evenly(-5, 5, 300), 0.4,
                      [](const std::vector<double>& p, double x) { return p[0] + p[1] * x; });
  Model truth = made_model(line, {3, -0.7}), start = made_model(line, {0, 0});
  truth.set(noise, {{.value = 0.5}});
  start.set(noise, {{.value = 0.3}});
  const std::vector<Unknown> unknowns = {{"line", 0}, {"line", 1}, {"more", 0}};
  const std::vector<double> hidden = {3, -0.7, 0.5};
  for (const bool wide : {false, true}) {
    Scores mean, spread;
    for (uint64_t seed = 1; seed <= 600; ++seed) {
      problem.observe(truth, {.seed = seed});
      const Fit fit = wide ? wide_fit(problem, start, unknowns, {1})
                           : problem.Problem::fit(start, unknowns, {1});
      for (size_t i = 0; i < 3; ++i)
        (i < 2 ? mean : spread).add(fit.value[i], fit.sigma[i], hidden[i]);
    }
    const std::string name = wide ? "wide fit" : "fit";
    mean.expect_normal(name + ", line");
    spread.expect_normal(name + ", noise");
  }
}

}  // namespace
}  // namespace seam::measurement
