#include "measurement/infer/random_effect.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

struct Data {
  Eigen::MatrixXd columns;
  Eigen::VectorXd residuals;
};

Data drawn(double size, uint64_t seed) {
  Data data{Eigen::MatrixXd(60, 7), Eigen::VectorXd(60)};
  const auto draw = [&](uint64_t stream, uint64_t index) { return normal({seed, stream}, index); };
  Eigen::VectorXd b(7);
  for (Eigen::Index k = 0; k < 7; ++k) {
    b[k] = size * draw(1, static_cast<uint64_t>(k));
    for (Eigen::Index i = 0; i < 60; ++i)
      data.columns(i, k) = draw(2 + static_cast<uint64_t>(k), static_cast<uint64_t>(i));
  }
  for (Eigen::Index i = 0; i < 60; ++i) data.residuals[i] = draw(20, static_cast<uint64_t>(i));
  data.residuals += data.columns * b;
  return data;
}

// Each coefficient's spread is a fifth less than that of the one before it.
Eigen::VectorXd ratios_of(const Data& data) {
  Eigen::VectorXd ratios(data.columns.cols());
  for (Eigen::Index k = 0; k < ratios.size(); ++k)
    ratios[k] = std::pow(0.8, static_cast<double>(k));
  return ratios;
}

RandomEffect effect_of(const Data& data) {
  return RandomCoefficients(data.columns.transpose() * data.columns, ratios_of(data))
      .effect(data.columns.transpose() * data.residuals);
}

// ln of the normal density of the residuals with coefficients of these spreads, but for a constant.
double log_density(const Data& data, const Eigen::VectorXd& spread) {
  const Eigen::Index n = data.residuals.size();
  const Eigen::MatrixXd covariance =
      Eigen::MatrixXd::Identity(n, n) +
      data.columns * spread.array().square().matrix().asDiagonal() * data.columns.transpose();
  const Eigen::LLT<Eigen::MatrixXd> root(covariance);
  const Eigen::MatrixXd lower = root.matrixL();
  return -0.5 * data.residuals.dot(root.solve(data.residuals)) -
         lower.diagonal().array().log().sum();
}

TEST(RandomEffect, GainIsTheRatioOfTheNormalDensities) {
  const Data data = drawn(0.4, 3);
  const RandomEffect effect = effect_of(data);
  ASSERT_EQ(effect.spread.size(), data.columns.cols());
  EXPECT_NEAR(effect.log_evidence,
              log_density(data, effect.spread) - log_density(data, 0 * effect.spread), 1e-6);
}

// Columns that differ by rounding alone tell no size: what they seem to gain is not there.
TEST(RandomEffect, GainsNoMoreThanItTakesFromTheResiduals) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Data data = drawn(1000, seed);
    for (Eigen::Index i = 0; i < 60; ++i) {
      for (Eigen::Index k = 1; k < 7; ++k)
        data.columns(i, k) = data.columns(i, 0) * (1 + 1e-9 * data.columns(i, k));
      data.residuals[i] += 1000 * normal({seed, 40}, static_cast<uint64_t>(i));
    }
    const RandomEffect effect = effect_of(data);
    const double taken =
        0.5 * (data.residuals.squaredNorm() -
               (data.residuals - data.columns * effect.coefficients).squaredNorm());
    EXPECT_LE(effect.log_evidence, taken * (1 + 1e-6)) << seed;
  }
}

TEST(RandomEffect, ItsSizeIsTheLikeliest) {
  const Data data = drawn(0.4, 4);
  const RandomEffect effect = effect_of(data);
  for (double factor = 0.05; factor < 20; factor *= 1.1)
    EXPECT_LE(log_density(data, factor * effect.spread), log_density(data, effect.spread) + 1e-3);
  EXPECT_TRUE(effect.spread.isApprox(effect.spread[0] * ratios_of(data)));
  EXPECT_GT(effect.spread[0], 0.15);
  EXPECT_LT(effect.spread[0], 1.5);
}

TEST(RandomEffect, NoiseAloneGainsNextToNothing) {
  double sum = 0;
  for (uint64_t seed = 1; seed <= 100; ++seed) sum += effect_of(drawn(0, seed)).log_evidence;
  EXPECT_LT(sum / 100, 0.5);
}

TEST(RandomEffect, CoefficientsAreTheMeanGivenTheData) {
  const Data data = drawn(0.4, 5);
  const RandomEffect effect = effect_of(data);
  // Of jointly normal b and r: cov(b, r) var(r)^-1 r.
  const Eigen::MatrixXd of_both =
      effect.spread.array().square().matrix().asDiagonal() * data.columns.transpose();
  const Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(60, 60) + data.columns * of_both;
  const Eigen::VectorXd mean =
      of_both * Eigen::LLT<Eigen::MatrixXd>(covariance).solve(data.residuals);
  EXPECT_LT((mean - effect.coefficients).norm(), 1e-8 * mean.norm());
}

}  // namespace
}  // namespace seam::measurement
