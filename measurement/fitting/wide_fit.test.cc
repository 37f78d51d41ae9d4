// Fits against closed forms and against a look at every place of a fine grid.
#include "measurement/fitting/wide_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "measurement/problem/made_problem.h"

namespace seam::measurement {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

double straight(const std::vector<double>& p, double x) {
  return p[0] + p[1] * x;
}

std::shared_ptr<const EffectDefinition> line_effect(double highest = 100) {
  return made_effect("line", {{.name = "a", .min = -100, .max = 100, .scale = 1},
                              {.name = "b", .min = -100, .max = highest, .scale = 0.1}});
}

const std::vector<Unknown> kLine = {{"line", 0}, {"line", 1}};

// Both fits of a straight line are the closed form's: values, errors and their correlation, the
// errors widened by the misfit where the noise is larger than stated.
TEST(Fits, OfALineAreTheClosedForm) {
  for (const double stated : {0.5, 0.2}) {
    MadeProblem problem(evenly(0, 10, 40), 0.5, straight);
    problem.observe(made_model(line_effect(), {3, -0.7}), {.seed = 21});
    // The same observations under another noise.
    MadeProblem judged(problem.x(), stated, straight);
    judged.take(problem.y());
    Eigen::MatrixXd a(40, 2);
    for (Eigen::Index i = 0; i < 40; ++i) a.row(i) << 1, problem.x()[static_cast<size_t>(i)];
    const Eigen::Map<const Eigen::VectorXd> y(problem.y().data(), 40);
    const Eigen::VectorXd best = a.colPivHouseholderQr().solve(Eigen::VectorXd(y));
    const double misfit = std::max(1.0, std::sqrt((y - a * best).squaredNorm() / 40) / stated);
    const Eigen::Matrix2d covariance =
        misfit * misfit * stated * stated * (a.transpose() * a).inverse();
    const Model start = made_model(line_effect(), {0, 0});
    for (const Fit& fit :
         {judged.Problem::fit(start, kLine, {1}), wide_fit(judged, start, kLine, {1})}) {
      EXPECT_TRUE(fit.converged);
      for (Eigen::Index i = 0; i < 2; ++i) {
        const double sigma = std::sqrt(covariance(i, i));
        EXPECT_NEAR(fit.value[static_cast<size_t>(i)], best[i], 0.03 * sigma);
        EXPECT_NEAR(fit.sigma[static_cast<size_t>(i)] / sigma, 1, 1e-3);
        EXPECT_FALSE(fit.at_bound[static_cast<size_t>(i)]);
      }
      EXPECT_NEAR(fit.covariance[1] / covariance(0, 1), 1, 2e-3);
      EXPECT_NEAR(fit.covariance[2] / covariance(0, 1), 1, 2e-3);
      EXPECT_EQ(fit.model.find("line")->values()[1], fit.value[1]);
    }
  }
}

TEST(Fits, StopAtABoundAndSaySo) {
  MadeProblem problem(evenly(0, 10, 40), 0.5, straight);
  problem.observe(made_model(line_effect(), {3, 2}), {.seed = 22});
  const Model start = made_model(line_effect(1.5), {0, 0});
  for (const Fit& fit :
       {problem.Problem::fit(start, kLine, {1}), wide_fit(problem, start, kLine, {1})}) {
    EXPECT_EQ(fit.value[1], 1.5);
    EXPECT_TRUE(fit.at_bound[1]);
    EXPECT_FALSE(fit.at_bound[0]);
    // The other one is the best beside it: the mean of what the slope leaves.
    double mean = 0;
    for (size_t i = 0; i < 40; ++i) mean += (problem.y()[i] - 1.5 * problem.x()[i]) / 40;
    EXPECT_NEAR(fit.value[0], mean, 0.03 * 0.5 / std::sqrt(40.0));
  }
}

// What the data do not tell has no error bar, and does not disturb the rest.
TEST(Fits, SayNothingOfWhatTheDataDoNotTell) {
  const auto effect = made_effect("line", {{.name = "a", .min = -100, .max = 100, .scale = 1},
                                           {.name = "idle", .min = -5, .max = 5, .scale = 1}});
  MadeProblem problem(evenly(0, 10, 25), 0.5,
                      [](const std::vector<double>& p, double) { return p[0]; });
  problem.observe(made_model(effect, {3, 0}), {.seed = 23});
  const Model start = made_model(effect, {0, 1});
  for (const Fit& fit :
       {problem.Problem::fit(start, kLine, {1}), wide_fit(problem, start, kLine, {1})}) {
    EXPECT_NEAR(fit.sigma[0], 0.1 * std::max(1.0, problem.score(fit.model, {1}).error()), 1e-4);
    EXPECT_TRUE(std::isinf(fit.sigma[1]));
    EXPECT_EQ(fit.value[1], 1);
  }
}

// Noise beyond the stated: the likelihood's best is the rest of the variance, and its error follows
// from that of a variance, v sqrt(2 / n), by d(s^2) = 2 s ds.
TEST(Fits, OfASpreadAreTheClosedForm) {
  constexpr size_t kRows = 500;
  const auto noise =
      made_effect("more", {{.name = "sigma", .min = 0, .max = 100, .scale = 1}}, true);
  MadeProblem problem(evenly(0, 1, kRows), 0.5,
                      [](const std::vector<double>&, double) { return 0; });
  problem.observe(made_model(noise, {0.6}), {.seed = 24});
  double variance = 0;
  for (const double y : problem.y()) variance += y * y / kRows;
  const double best = std::sqrt(variance - 0.25);
  const double sigma = variance * std::sqrt(2.0 / kRows) / (2 * best);
  const Model start = made_model(noise, {0.3});
  for (const Fit& fit : {problem.Problem::fit(start, {{"more", 0}}, {1}),
                         wide_fit(problem, start, {{"more", 0}}, {1})}) {
    EXPECT_NEAR(fit.value[0], best, 0.2 * sigma);
    EXPECT_NEAR(fit.sigma[0] / sigma, 1, 0.05);
  }
}

// Of noise that is not there a fit says zero, and its error bar holds what chance may hide: the
// likelihood falls by a half at about s^2 = v sqrt(2 / n).
TEST(Fits, OfASpreadThatIsNotThere) {
  constexpr size_t kRows = 400;
  const auto noise =
      made_effect("more", {{.name = "sigma", .min = 0, .max = 100, .scale = 0.5}}, true);
  MadeProblem problem(evenly(0, 1, kRows), 0.5,
                      [](const std::vector<double>&, double) { return 0; });
  // Half a standard error below the stated noise.
  problem.observe(made_model(noise, {0}), {.seed = 25});
  double variance = 0;
  for (const double y : problem.y()) variance += y * y / kRows;
  std::vector<double> y = problem.y();
  for (double& value : y) value *= 0.49 / std::sqrt(variance);
  problem.take(y);
  const Model start = made_model(noise, {0.3});
  for (const Fit& fit : {problem.Problem::fit(start, {{"more", 0}}, {1}),
                         wide_fit(problem, start, {{"more", 0}}, {1})})
    EXPECT_LT(fit.value[0], 2e-3);
}

// A limit whose neutral value is infinite: the best of a fine grid, and the interval in which twice
// the log-likelihood falls by less than 1.
TEST(WideFit, OfALimitIsTheBestOfAGrid) {
  const auto limit = made_effect("limit", {{.name = "most",
                                            .neutral = kInf,
                                            .min = 0.01,
                                            .max = kInf,
                                            .scale = 5,
                                            .fit_reciprocal = true}});
  MadeProblem problem(evenly(0, 10, 80), 0.3,
                      [](const std::vector<double>& p, double x) { return std::min(x, p[0]); });
  problem.observe(made_model(limit, {6.3}), {.seed = 26});
  const auto chi2 = [&](double most) {
    double sum = 0;
    for (size_t i = 0; i < problem.x().size(); ++i)
      sum += std::pow((problem.y()[i] - std::min(problem.x()[i], most)) / 0.3, 2);
    return sum;
  };
  double best = 5;
  for (double most = 5; most < 8; most += 1e-4) {
    if (chi2(most) < chi2(best)) best = most;
  }
  double low = best, high = best;
  while (chi2(low) < chi2(best) + 1) low -= 1e-4;
  while (chi2(high) < chi2(best) + 1) high += 1e-4;
  for (const double start : {kInf, 3.0, 9.0}) {
    const Fit fit = wide_fit(problem, made_model(limit, {start}), {{"limit", 0}}, {1});
    EXPECT_NEAR(fit.value[0], best, 0.1 * (high - low)) << start;
    const double misfit = std::max(1.0, problem.score(fit.model, {1}).error());
    EXPECT_NEAR(fit.sigma[0] / (misfit * 0.5 * (high - low)), 1, 0.1) << start;
    EXPECT_FALSE(fit.at_bound[0]) << start;
  }
}

// Between two rows a delay changes nothing: the middle, and the error of a uniform distribution.
TEST(WideFit, OfAStaircaseIsTheMiddleOfTheTread) {
  const auto delay = made_effect("delay", {{.name = "d", .min = 0, .max = 5, .scale = 0.3}});
  MadeProblem problem(evenly(0, 10, 101), 0.01, [](const std::vector<double>& p, double x) {
    return x - 5 >= p[0] ? 1.0 : 0.0;
  });
  problem.observe(made_model(delay, {0.733}), {.seed = 27});
  // The row at 5.7 is before the step, that at 5.8 after it; from 0.4 three rows are wrong.
  const Fit fit = wide_fit(problem, made_model(delay, {0.4}), {{"delay", 0}}, {1});
  EXPECT_NEAR(fit.value[0], 0.75, 2e-3);
  EXPECT_NEAR(fit.sigma[0], 0.1 / std::sqrt(12.0), 1e-3);
}

// A parameter on demand stays neutral, with no error, until twice the log-likelihood asks for it.
TEST(WideFit, FreesAParameterOnDemandOnlyWhereItPays) {
  const auto wave = made_effect(
      "line", {{.name = "a", .min = -100, .max = 100, .scale = 1},
               {.name = "k", .neutral = 0, .min = -2, .max = 2, .scale = 0.1, .on_demand = true}});
  for (const double k : {0.0, 0.5}) {
    MadeProblem problem(evenly(0, 10, 60), 0.5, [](const std::vector<double>& p, double x) {
      return p[0] + p[1] * (x - 5);
    });
    problem.observe(made_model(wave, {1, k}), {.seed = 28});
    double sxy = 0, sxx = 0;
    for (size_t i = 0; i < 60; ++i) {
      sxy += (problem.x()[i] - 5) * problem.y()[i];
      sxx += (problem.x()[i] - 5) * (problem.x()[i] - 5);
    }
    const Fit fit = wide_fit(problem, made_model(wave, {0, 0}), kLine, {1});
    if (k == 0) {
      ASSERT_LT(sxy * sxy / sxx / 0.25, 10.8);
      EXPECT_EQ(fit.value[1], 0);
      EXPECT_EQ(fit.sigma[1], 0);
    } else {
      EXPECT_NEAR(fit.value[1], sxy / sxx, 0.03 * 0.5 / std::sqrt(sxx));
      EXPECT_GT(fit.sigma[1], 0);
    }
  }
}

// Derivatives by the limit itself: of min(x, limit), where the limit binds, -1 / sigma of the
// residual.
TEST(WideFit, JacobianIsByTheParameterItself) {
  const auto limit = made_effect("limit", {{.name = "most",
                                            .neutral = kInf,
                                            .min = 0.01,
                                            .max = kInf,
                                            .scale = 5,
                                            .fit_reciprocal = true}});
  MadeProblem problem(evenly(0, 10, 80), 0.25,
                      [](const std::vector<double>& p, double x) { return std::min(x, p[0]); });
  problem.observe(made_model(limit, {6.3}), {.seed = 29});
  const auto columns = wide_jacobian(problem, made_model(limit, {6.3}), {{"limit", 0}}, {1});
  for (size_t i = 0; i < problem.x().size(); ++i) {
    if (std::abs(problem.x()[i] - 6.3) < 0.1) continue;
    EXPECT_NEAR(columns[0][i], problem.x()[i] < 6.3 ? 0 : -4, 0.01) << problem.x()[i];
  }
}

}  // namespace
}  // namespace seam::measurement
